//! A program that measures: what it is called, and where its reports go.

use crate::cli::{
    args::{self, Command},
    bench, bias, card, compare, costs, list, merge, plan, regret, stability, usage, wgsl, which,
};
use anyhow::Result;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};
use umbrage_core::Invalid;
use umbrage_plan::catalogue::{Catalogue, CatalogueEntry};
use umbrage_wgpu::AdapterChoice;

/// A program that measures shadow techniques, controlled by its command line.
#[derive(Clone, Debug)]
pub struct Program {
    /// What users type to start it, as help and messages show it: `umbrage`.
    pub invocation: &'static str,
    /// Folder for reports where `--out` names none: that of `compare` goes to its subfolder `compare`.
    pub reports: PathBuf,
    /// The techniques that `compare`, `stability` and `plan` know: the built-in ones, and those of the program.
    pub catalogue: Catalogue,
    /// Times light sets against a program written by hand, for `card`; `None` if the program has none.
    pub light_set_ratios: Option<LightSetRatios>,
}

/// Returns times of light sets over times of a program written by hand, on this adapter, by what was timed.
pub type LightSetRatios = fn(&AdapterChoice) -> Result<BTreeMap<String, f64>>;

impl Default for Program {
    /// Returns the program `umbrage`, whose reports go to subfolders of `umbrage-reports` in the current folder.
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
    /// Returns the program with one technique more, which is then on the command line, in charts, in the stability matrix and
    /// among the planner's candidates.
    ///
    /// # Errors
    /// Errors if there is a technique of that name.
    pub fn with(mut self, technique: CatalogueEntry) -> Result<Self, Invalid> {
        self.catalogue = self.catalogue.with(technique)?;
        Ok(self)
    }

    /// Runs the command that the command line asks for. Returns the exit code: 0 (done), 2 (what was asked for can't be: a name, a file or
    /// a number is wrong) or 1 (failed otherwise).
    ///
    /// Prints errors to standard error. Ends the process with 0 after `--help`, with 2 after wrong usage, and with 141
    /// when nobody reads what it prints.
    pub fn run(&self) -> ExitCode {
        let command = args::parse(self.invocation);
        let Err(error) = self.dispatch(&command) else {
            return ExitCode::SUCCESS;
        };
        eprintln!("error: {error:#}");
        ExitCode::from(usage::exit_code(&error))
    }

    fn dispatch(&self, command: &Command) -> Result<()> {
        match command {
            Command::Compare(options) if options.list => list::list(self),
            Command::Compare(options) => compare::compare(self, options),
            Command::Merge(options) => merge::merge(options),
            Command::Stability(options) => stability::stability(self, options),
            Command::Which(options) => which::which(self, options),
            Command::Bench(options) if options.costs => costs::costs(options),
            Command::Bench(options) => bench::bench(options),
            Command::Card(options) => card::card(self, options),
            Command::Wgsl(options) => wgsl::wgsl(self, options),
            Command::Plan(options) if options.regret => regret::regret(self, options),
            Command::Plan(options) => plan::plan(self, options),
            Command::Bias(options) => bias::bias(self, options),
        }
    }

    /// Returns the folder for a command's report: the one that was asked for, else a subfolder with the command's name.
    pub(crate) fn folder(&self, asked_for: Option<&Path>, command: &str) -> PathBuf {
        match asked_for {
            Some(folder) => folder.to_owned(),
            None => self.reports.join(command),
        }
    }
}
