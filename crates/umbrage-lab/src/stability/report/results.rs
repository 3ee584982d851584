//! The file of results: what other programs, and `compare`'s page, read.

use super::pictures::PictureNames;
use crate::{
    compare::{Backends, CompareOptions, Environment},
    output::program_hash,
    stability::{cell::Stability, sweeps::curve::Sweep},
};
use serde::{Deserialize, Serialize};
use std::path::Path;
use umbrage_core::Invalid;

/// Version of this data's format; grows with every change that programs which read it would notice.
pub const STABILITY_SCHEMA: u32 = 1;

/// The file's name.
pub(super) const FILE: &str = "results.json";

/// All results of a run, written to `results.json` as they are.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct StabilityResults {
    /// [`STABILITY_SCHEMA`] when it was written.
    pub schema: u32,
    /// Where and with what it was made; undated, as it is the same whenever it is made.
    pub environment: Environment,
    /// Hash of the program that played.
    pub program: String,
    /// The matrix and the windows of bias.
    #[serde(flatten)]
    pub stability: Stability,
    /// The sweeps; empty if single rows or techniques were asked for.
    pub sweeps: Vec<Sweep>,
    /// For each case and each of its cells the file of its picture, relative to this one; none
    /// where there is no picture.
    pub pictures: PictureNames,
}

/// The schema alone: results of other versions have other fields.
#[derive(Deserialize)]
struct Version {
    schema: u32,
}

impl StabilityResults {
    /// Returns results that this program has played on these backends.
    pub fn new(stability: Stability, sweeps: Vec<Sweep>, backends: &Backends) -> Self {
        let undated = CompareOptions {
            runs: None,
            ..CompareOptions::default()
        };
        Self {
            schema: STABILITY_SCHEMA,
            environment: backends.environment(&undated),
            program: program_hash(),
            pictures: super::pictures::names(&stability),
            stability,
            sweeps,
        }
    }

    /// Reads a `results.json`, or the one in a folder that `stability` wrote.
    ///
    /// # Errors
    /// Errors if it can't be read, is no such file, or has another schema than this program's.
    pub fn read(path: &Path) -> Result<Self, Invalid> {
        let file = if path.is_dir() {
            path.join(FILE)
        } else {
            path.to_owned()
        };
        let what = format!("stability results `{}`", file.display());
        let help = "give the folder that `stability` wrote, or the results.json in it";
        let refuse = |why: String| Invalid::new(what.clone(), why, help);
        let text = std::fs::read(&file).map_err(|e| refuse(format!("cannot be read: {e}")))?;
        let version: Version = serde_json::from_slice(&text).map_err(|_| {
            refuse("holds no results of `stability` with a schema number".to_owned())
        })?;
        if version.schema != STABILITY_SCHEMA {
            let why = format!(
                "has schema {}, this program's is {STABILITY_SCHEMA}",
                version.schema
            );
            return Err(Invalid::new(
                what,
                why,
                "run `stability` again with this version",
            ));
        }
        serde_json::from_slice(&text)
            .map_err(|e| refuse(format!("is not what `stability` writes: {e}")))
    }
}
