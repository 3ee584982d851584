//! Dispatches the command line to its command.

use super::{
    args::{self, Command},
    bench, bias, card, compare, costs, list, merge, plan,
    program::Program,
    regret, stability, usage, wgsl, which,
};
use anyhow::Result;
use std::process::ExitCode;

impl Program {
    /// Runs the command of the command line. Prints errors to standard error.
    ///
    /// Returns the exit code: 0 (success), 2 (a name, file or number of the user is invalid) or 1
    /// (any other failure).
    ///
    /// Ends the process with 0 after `--help`, with 2 after wrong usage, and with 141 if standard
    /// output is closed.
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
}
