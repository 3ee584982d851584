//! A program that measures: what it is called, and where its reports go.

use anyhow::Result;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};
use umbrage_core::Invalid;
use umbrage_plan::catalogue::{Catalogue, CatalogueEntry};
use umbrage_wgpu::AdapterChoice;

/// A program that measures shadow techniques, controlled by its command line.
#[derive(Clone, Debug)]
pub struct Program {
    /// What users type to start it, as help and messages show it: `umbrage`.
    pub invocation: &'static str,
    /// Folder for reports where `--out` names none: that of `compare` goes to its subfolder
    /// `compare`.
    pub reports: PathBuf,
    /// The techniques that `compare`, `stability` and `plan` know: the built-in ones, and those of
    /// the program.
    pub catalogue: Catalogue,
    /// Times light sets against a program written by hand, for `card`; `None` if the program has
    /// none.
    pub light_set_ratios: Option<LightSetRatios>,
}

/// Returns times of light sets over times of a program written by hand, on this adapter, by what
/// was timed.
pub type LightSetRatios = fn(&AdapterChoice) -> Result<BTreeMap<String, f64>>;

impl Default for Program {
    /// Returns the program `umbrage`, whose reports go to subfolders of `umbrage-reports` in the
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
    /// Returns the program with one technique more, which is then on the command line, in charts,
    /// in the stability matrix and among the planner's candidates.
    ///
    /// # Errors
    /// Errors if there is a technique of that name.
    pub fn with(mut self, technique: CatalogueEntry) -> Result<Self, Invalid> {
        self.catalogue = self.catalogue.with(technique)?;
        Ok(self)
    }

    /// Returns the folder for a command's report: the one that was asked for, else a subfolder with
    /// the command's name.
    pub(crate) fn folder(&self, asked_for: Option<&Path>, command: &str) -> PathBuf {
        match asked_for {
            Some(folder) => folder.to_owned(),
            None => self.reports.join(command),
        }
    }
}
