//! The results of `stability` that `compare` and `merge` show with their settings.

use crate::cli::{program::Program, usage::Usage};
use crate::report::StabilitySource;
use anyhow::Result;
use std::path::Path;

/// Reads the results named on the command line.
pub(crate) fn read(path: &Path) -> Result<StabilitySource> {
    let source = StabilitySource::read(path).map_err(|e| Usage(format!("--stability: {e}")))?;
    Ok(source)
}

/// Returns the results named on the command line, or those of the last run in the standard folder,
/// and prints which. `None` if there are none: the report then explains how to get them.
pub(crate) fn of_run(
    program: &Program,
    stability: Option<&Path>,
    deterministic: bool,
) -> Result<Option<StabilitySource>> {
    if let Some(path) = stability {
        return read(path).map(Some);
    }
    let folder = program.folder(None, "stability");
    // Output must not depend on leftover files.
    if deterministic || !folder.join("results.json").is_file() {
        return Ok(None);
    }
    match StabilitySource::read(&folder) {
        Ok(source) => {
            let (folder, reported) = (folder.display(), source.description());
            println!("stability verdicts from {folder}: {reported}");
            Ok(Some(source))
        }
        Err(why) => {
            println!("note: no stability verdicts: {why}");
            Ok(None)
        }
    }
}
