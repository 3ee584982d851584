//! Output of `cargo xtask` itself that is not read.

mod unread;

const PROGRAM: &str = env!("CARGO_BIN_EXE_xtask");

#[test]
fn an_unread_overview_does_not_panic() {
    unread::assert_ends_quietly(PROGRAM, &["--help"]);
    unread::assert_help_does_not_panic(PROGRAM, &["compare", "--help"]);
    unread::assert_fails_without_panic(PROGRAM, &["compere"]);
    unread::assert_fails_without_panic(PROGRAM, &[]);
}
