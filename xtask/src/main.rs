//! The project's own commands. They end with 0 (done), 1 (failed), 2 (wrong usage) or 141 (nobody reads on).

#[macro_use]
mod print;

mod adapter;
mod bless;
mod ci;
mod cli;
mod measure;
mod run;
mod swiftshader;
mod test;
mod tidy;

use clap::Parser as _;
use cli::{Cli, Command};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.command {
        Command::Bias(_)
        | Command::Compare(_)
        | Command::Merge(_)
        | Command::Stability(_)
        | Command::Plan(_)
        | Command::Bench(_) => measure::dispatch(&cli.command),
        Command::Bless(options) => bless::bless(options),
        Command::Test(options) => test::test(options),
        Command::Tidy => tidy::tidy(),
        Command::Ci(options) => ci::ci(options),
    };
    let Err(error) = done else {
        return ExitCode::SUCCESS;
    };
    eprintln!("error: {error:#}");
    // Wrong usage that only the command itself can see, such as a scene's name.
    ExitCode::from(if error.is::<run::Usage>() { 2 } else { 1 })
}
