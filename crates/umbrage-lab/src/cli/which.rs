//! `which`: writes the page that recommends techniques, from measured results.

use crate::{
    card::{self, Card},
    cli::{program::Program, usage::Usage},
    error::LabError,
    which::write,
};
use anyhow::Result;
use clap::Args;
use std::path::{Path, PathBuf};
use umbrage_core::Invalid;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask which                                              from the last results
  cargo xtask which target/compare target/stability --out docs   docs/which.md, .html and images
  cargo xtask which --card docs/cards/nvidia-h100.json           with the times of a card")]
pub(crate) struct WhichArguments {
    /// Folder written by `compare`, with full-size scenes. Default: target/compare in the
    /// repository
    #[arg(value_name = "COMPARED")]
    pub(crate) compared: Option<PathBuf>,
    /// Folder written by `stability`. Default: target/stability in the repository
    #[arg(value_name = "STABILITY")]
    pub(crate) stability: Option<PathBuf>,
    /// File of a graphics card (.json), as written by `card`: also recommend by its times
    #[arg(long, value_name = "FILE")]
    pub(crate) card: Option<PathBuf>,
    /// Folder for the page and its images. Default: target/which in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

/// Writes the page. Errors if a folder has no such results.
pub(crate) fn which(program: &Program, arguments: &WhichArguments) -> Result<()> {
    let compared = program.folder(arguments.compared.as_deref(), "compare");
    let stability = program.folder(arguments.stability.as_deref(), "stability");
    let out = program.folder(arguments.out.as_deref(), "which");
    let card = arguments.card.as_deref().map(read_card).transpose()?;
    let option = arguments
        .card
        .as_ref()
        .map(|file| format!(" --card {}", file.display()));
    let command = format!("{} which{}", program.invocation, option.unwrap_or_default());
    let written = write(&compared, &stability, card.as_ref(), &out, &command);
    let pages = written.map_err(|e| match e {
        LabError::Invalid(e) => Usage(e.to_string()).into(),
        e => anyhow::Error::from(e),
    })?;
    for page in pages {
        println!("page: {}", page.display());
    }
    Ok(())
}

/// Reads a card with times. Errors if the file is not a card or has no times.
fn read_card(file: &Path) -> Result<Card> {
    let card = card::read(file).map_err(|e| Usage(e.to_string()))?;
    let has_times = card
        .times
        .iter()
        .flatten()
        .any(|time| time.milliseconds.is_some());
    if !has_times {
        let what = format!("card `{}`", file.display());
        let help = "measure them with `cargo xtask card`";
        return Err(
            Usage(Invalid::new(what, "has no times at full clock", help).to_string()).into(),
        );
    }
    Ok(card)
}
