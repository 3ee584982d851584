//! The program that runs the commands: its name, folders and techniques.

use anyhow::Result;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};
use umbrage_core::Invalid;
use umbrage_plan::catalogue::{Catalogue, CatalogueEntry};
use umbrage_wgpu::AdapterChoice;

/// A program with the commands of this crate.
#[derive(Clone, Debug)]
pub struct Program {
    /// The text that starts it in a shell, for help and messages: `umbrage`.
    pub invocation: &'static str,
    /// Folder for reports without `--out`. Each command has a subfolder, such as `compare`.
    pub reports: PathBuf,
    /// The techniques of `compare`, `stability` and `plan`: the built-in ones and the program's
    /// own.
    pub catalogue: Catalogue,
    /// Benchmark of light sets against a hand-written program, for `card`. `None` if the program
    /// has none.
    pub light_set_ratios: Option<LightSetRatios>,
}

/// A function that returns times of light sets relative to those of a hand-written program on this
/// adapter, by the name of the measurement.
pub type LightSetRatios = fn(&AdapterChoice) -> Result<BTreeMap<String, f64>>;

impl Default for Program {
    /// Returns the program `umbrage`. Its reports are in subfolders of `umbrage-reports` in the
    /// current folder.
    fn default() -> Self {
        Self {
            invocation: "umbrage",
            reports: PathBuf::from("umbrage-reports"),
            catalogue: Catalogue::built_in(),
            light_set_ratios: None,
        }
    }
}

impl Program {
    /// Adds a technique. It is then available on the command line, in charts, in the stability
    /// matrix and as a candidate of the planner.
    ///
    /// # Errors
    /// Errors if there is a technique with the same name.
    pub fn with(mut self, technique: CatalogueEntry) -> Result<Self, Invalid> {
        self.catalogue = self.catalogue.with(technique)?;
        Ok(self)
    }

    /// Returns the folder for a command's report: the requested one, or else a subfolder with the
    /// command's name.
    pub(crate) fn folder(&self, wanted: Option<&Path>, command: &str) -> PathBuf {
        match wanted {
            Some(folder) => folder.to_owned(),
            None => self.reports.join(command),
        }
    }
}
