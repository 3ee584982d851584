//! Prints the graphics adapter that the tests will use; ends with 1 where there is none.

use std::process::ExitCode;

fn main() -> ExitCode {
    match umbrage_tests::adapter::open() {
        Ok(on) => println!("{}", on.adapter),
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
