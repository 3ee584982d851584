//! Programs whose output is not read to its end, as in `cargo xtask compare --list | head -3`. The
//! tests of all three programs use this file.

use std::process::{Command, ExitStatus, Stdio};

/// Exit code that shells report for a tool that wrote into a closed pipe: 128 plus the signal's
/// number, 13.
const CLOSED_PIPE: i32 = 141;

/// Exit code of a panic.
const PANIC: i32 = 101;

/// Runs a program into pipes that were closed before it started. Returns its exit status, and its
/// error output unless that was closed, too.
fn run_unread(program: &str, arguments: &[&str], errors_too: bool) -> (ExitStatus, String) {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let errors = if errors_too {
        Stdio::from(writer.try_clone().expect("a pipe"))
    } else {
        Stdio::piped()
    };
    let mut command = Command::new(program);
    command
        .args(arguments)
        .stdin(Stdio::null())
        .stderr(errors)
        .stdout(writer);
    let child = command.spawn().expect("the program starts");
    let done = child.wait_with_output().expect("the program ends");
    let errors = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status, errors)
}

/// Panics unless the program succeeds when its output is read, and ends without a message when it
/// isn't.
pub(crate) fn assert_ends_quietly(program: &str, arguments: &[&str]) {
    let mut command = Command::new(program);
    let read = command.args(arguments).output();
    let code = read.expect("the program starts").status.code();
    assert_eq!(code, Some(0), "{arguments:?} succeeds when it is read");
    let (status, errors) = run_unread(program, arguments, false);
    assert_eq!(errors, "", "{arguments:?}");
    // The write failed, and the program noticed it.
    assert_eq!(status.code(), Some(CLOSED_PIPE), "{arguments:?}");
}

/// Panics if the program prints an error when its help is not read.
pub(crate) fn assert_help_does_not_panic(program: &str, arguments: &[&str]) {
    let (_, errors) = run_unread(program, arguments, false);
    assert_eq!(errors, "", "{arguments:?}");
}

/// Panics unless the program fails without a panic when its errors are not read.
pub(crate) fn assert_fails_without_panic(program: &str, arguments: &[&str]) {
    let (status, _) = run_unread(program, arguments, true);
    let failed = matches!(status.code(), Some(code) if code != PANIC && code != 0);
    assert!(failed, "{arguments:?}: {status}");
}
