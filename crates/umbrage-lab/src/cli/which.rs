//! `which`: writes the page that says which technique to use, from what was measured.

use crate::cli::{args::WhichArguments, program::Program, usage::Usage};
use crate::{LabError, which::write};
use anyhow::Result;

/// Writes the page; errors if a folder holds no such results.
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
