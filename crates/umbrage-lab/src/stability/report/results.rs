//! The file of results, which other programs and the page of `compare` read.

use super::pictures::PictureNames;
use crate::{
    compare::{Backends, CompareOptions, Environment},
    output::program_hash,
    stability::{cell::Stability, sweeps::curve::Sweep},
};
use serde::{Deserialize, Serialize};
use std::path::Path;
use umbrage_core::Invalid;

/// Version of this data's format. It grows with every change that affects programs that read it.
pub const STABILITY_SCHEMA: u32 = 1;

/// Name of the file.
pub(super) const FILE: &str = "results.json";

/// All results of a run, as written to `results.json`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct StabilityResults {
    /// [`STABILITY_SCHEMA`] of the program that wrote it.
    pub schema: u32,
    /// Environment of the run; undated, so that equal runs write equal files.
    pub environment: Environment,
    /// Hash of the program that ran.
    pub program: String,
    /// The matrix and the bias windows.
    #[serde(flatten)]
    pub stability: Stability,
    /// The sweeps; empty if single rows or techniques were selected.
    pub sweeps: Vec<Sweep>,
    /// Image file of each cell of each case, relative to this file; `None` without an image.
    pub pictures: PictureNames,
}

/// Only the schema: results of other versions have other fields.
#[derive(Deserialize)]
struct Version {
    schema: u32,
}

impl StabilityResults {
    /// Returns results of this program on these backends.
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
    /// Errors if it can't be read, is not such a file, or has another schema than this program's.
    pub fn read(path: &Path) -> Result<Self, Invalid> {
        let file = if path.is_dir() {
            path.join(FILE)
        } else {
            path.to_owned()
        };
        let what = format!("stability results `{}`", file.display());
        let help = "pass the folder that `stability` wrote, or the results.json in it";
        let refuse = |why: String| Invalid::new(what.clone(), why, help);
        let text = std::fs::read(&file).map_err(|e| refuse(format!("cannot be read: {e}")))?;
        let version: Version = serde_json::from_slice(&text).map_err(|_| {
            refuse("contains no results of `stability` with a schema number".to_owned())
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
