//! `cargo xtask test`, `bless`, `tidy`, `ci`, `card --pack`, `web`, `site` and `release-check`.
//! Exit codes: 0 (done), 1 (failed), 2 (wrong usage) or 141 (output closed).

#[path = "../../../crates/umbrage-lab/src/print.rs"]
#[macro_use]
mod print;

mod adapter;
mod bless;
mod card;
mod ci;
mod cli;
mod release;
mod run;
mod serve;
mod site;
mod swiftshader;
mod test;
mod tidy;
mod tools;
mod web;
mod wheel;

use clap::Parser as _;
use cli::{Cli, Command};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.command {
        Command::Test(options) => test::test(options),
        Command::Bless(options) => bless::bless(options),
        Command::Tidy => tidy::tidy(),
        Command::Ci(options) => ci::ci(options),
        Command::Card(options) => card::pack(options),
        Command::Web(options) => web::web(options),
        Command::Site(options) => site::site(options),
        Command::ReleaseCheck(options) => release::release_check(options),
    };
    let Err(error) = done else {
        return ExitCode::SUCCESS;
    };
    eprintln!("error: {error:#}");
    // Wrong usage that only the command itself detects, such as the name of a golden image.
    ExitCode::from(if error.is::<run::Usage>() { 2 } else { 1 })
}
