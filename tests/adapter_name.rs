//! Prints the graphics adapter of the tests; exits with 1 if there is none. With `--pinned`, also
//! exits with 1 if the adapter's driver is not the pinned one, whose results are bit-equal, and
//! prints which it is.

use std::process::ExitCode;
use umbrage_tests::{adapter, gpu::gpu};

fn main() -> ExitCode {
    match adapter::open() {
        Ok(on) => println!("{}", on.adapter),
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
    }
    let pinned = std::env::args().any(|argument| argument == "--pinned");
    if pinned && let Err(why) = gpu().check_pinned_driver() {
        eprintln!("error: {why}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
