//! Commands whose output is not read to its end.

#[path = "../../tests/unread/mod.rs"]
mod unread;

const PROGRAM: &str = env!("CARGO_BIN_EXE_xtask-measure");

#[test]
fn unread_output_does_not_panic() {
    unread::assert_ends_quietly(PROGRAM, &["compare", "--list"]);
    unread::assert_ends_quietly(PROGRAM, &["stability", "--list"]);
    unread::assert_ends_quietly(PROGRAM, &["wgsl", "hard"]);
    unread::assert_help_does_not_panic(PROGRAM, &["plan", "--help"]);
    unread::assert_fails_without_panic(PROGRAM, &["plan"]);
    unread::assert_fails_without_panic(PROGRAM, &["merge", "s1"]);
}
