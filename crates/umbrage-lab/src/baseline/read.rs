//! The results of an earlier run.

use crate::compare::{Comparison, SCHEMA};
use serde::Deserialize;
use std::path::Path;
use umbrage_core::Invalid;

/// The oldest schema that is still read: what came later may be missing.
const OLDEST: u32 = 3;

/// The schema alone: results of other versions have other fields.
#[derive(Deserialize)]
struct Version {
    schema: u32,
}

/// Reads a `results.json`.
///
/// # Errors
/// When it can't be read, is no such file, or has a schema that is too old or newer than this program.
pub fn read(path: &Path) -> Result<Comparison, Invalid> {
    let what = format!("baseline `{}`", path.display());
    let mend = "give the results.json that `cargo xtask compare` wrote";
    let refuse = |why: String| Invalid::new(what.clone(), why, mend);
    let text = std::fs::read(path).map_err(|e| refuse(format!("cannot be read: {e}")))?;
    let version: Version = serde_json::from_slice(&text).map_err(|e| refuse(format!("holds no results: {e}")))?;
    if !(OLDEST..=SCHEMA).contains(&version.schema) {
        let why = format!("has schema {}, this program's is {SCHEMA}", version.schema);
        return Err(Invalid::new(what, why, "make the baseline anew with this version"));
    }
    serde_json::from_slice(&text).map_err(|e| refuse(format!("is damaged: {e}")))
}
