//! The results of `stability` that `compare` and `merge` show beside their settings.

use crate::cli::{program::Program, usage::Usage};
use crate::report::StabilitySource;
use anyhow::Result;
use std::path::Path;

/// Reads the results that the command line names.
pub(crate) fn read(path: &Path) -> Result<StabilitySource> {
    let source = StabilitySource::read(path).map_err(|e| Usage(format!("--stability: {e}")))?;
    Ok(source)
}

/// Returns the results that the command line names, or those of the last run in the standard
/// folder; says which. None without any: the report then says how to get them.
pub(crate) fn of_run(
    program: &Program,
    stability: Option<&Path>,
    deterministic: bool,
) -> Result<Option<StabilitySource>> {
    if let Some(path) = stability {
        return read(path).map(Some);
    }
    let folder = program.folder(None, "stability");
    // What comes out twice must not depend on what lies around.
    if deterministic || !folder.join("results.json").is_file() {
        return Ok(None);
    }
    match StabilitySource::read(&folder) {
        Ok(source) => {
            let (folder, told) = (folder.display(), source.told());
            println!("stability verdicts are those in {folder}: {told}");
            Ok(Some(source))
        }
        Err(why) => {
            println!("note: no stability verdicts: {why}");
            Ok(None)
        }
    }
}
