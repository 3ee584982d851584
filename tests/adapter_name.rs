//! Prints the graphics adapter that the tests will use; ends with 1 where there is none. With
//! `--pinned` it ends with 1, too, where the adapter's driver is not the one on which bits are
//! promised, and says which it is.

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
