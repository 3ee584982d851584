//! Commands whose output is not read to its end.

#[path = "../../tests/unread/mod.rs"]
#[expect(
    dead_code,
    reason = "all commands that end well take long; the other programs have short ones"
)]
mod unread;

const PROGRAM: &str = env!("CARGO_BIN_EXE_xtask-upkeep");

#[test]
fn unread_output_does_not_panic() {
    unread::assert_help_does_not_panic(PROGRAM, &["--help"]);
    unread::assert_fails_without_panic(PROGRAM, &["bless", "--ouch"]);
}
