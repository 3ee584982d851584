//! `which`: writes the page that recommends techniques, from measured results.

use crate::{
    cli::{program::Program, usage::Usage},
    error::LabError,
    which::write,
};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask which                                              from the last results
  cargo xtask which target/compare target/stability --out docs   docs/which.md, .html and images")]
pub(crate) struct WhichArguments {
    /// Folder written by `compare`, with full-size scenes. Default: target/compare in the
    /// repository
    #[arg(value_name = "COMPARED")]
    pub(crate) compared: Option<PathBuf>,
    /// Folder written by `stability`. Default: target/stability in the repository
    #[arg(value_name = "STABILITY")]
    pub(crate) stability: Option<PathBuf>,
    /// Folder for the page and its images. Default: target/which in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

/// Writes the page. Errors if a folder has no such results.
pub(crate) fn which(program: &Program, arguments: &WhichArguments) -> Result<()> {
    let compared = program.folder(arguments.compared.as_deref(), "compare");
    let stability = program.folder(arguments.stability.as_deref(), "stability");
    let out = program.folder(arguments.out.as_deref(), "which");
    let command = format!("{} which", program.invocation);
    let pages = write(&compared, &stability, &out, &command).map_err(|e| match e {
        LabError::Invalid(e) => Usage(e.to_string()).into(),
        e => anyhow::Error::from(e),
    })?;
    for page in pages {
        println!("page: {}", page.display());
    }
    Ok(())
}
