//! Commands whose output nobody reads to its end, as in `cargo xtask compare --list | head -3`.

use std::process::{Command, ExitStatus, Stdio};

/// Runs the built program into pipes that were closed before it started.
fn unread(arguments: &[&str], errors_too: bool) -> (ExitStatus, String) {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let errors = || {
        if errors_too {
            Stdio::from(writer.try_clone().expect("a pipe"))
        } else {
            Stdio::piped()
        }
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command
        .args(arguments)
        .stdin(Stdio::null())
        .stderr(errors())
        .stdout(writer.try_clone().expect("a pipe"));
    let done = command
        .spawn()
        .expect("the program starts")
        .wait_with_output()
        .expect("the program ends");
    (
        done.status,
        String::from_utf8_lossy(&done.stderr).into_owned(),
    )
}

fn read(arguments: &[&str]) -> Option<i32> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command
        .args(arguments)
        .output()
        .expect("the program starts")
        .status
        .code()
}

fn ends_quietly(arguments: &[&str]) {
    assert_eq!(
        read(arguments),
        Some(0),
        "{arguments:?} works where it is read"
    );
    let (status, errors) = unread(arguments, false);
    assert_eq!(errors, "", "{arguments:?}");
    // What shells say of a tool that a closed pipe ended; so the write did fail, and the program noticed.
    assert_eq!(status.code(), Some(141), "{arguments:?}");
}

#[test]
fn tables_end_quietly() {
    ends_quietly(&["tidy"]);
}

#[cfg(feature = "measure")]
#[test]
fn what_measures_ends_quietly() {
    ends_quietly(&["compare", "--list"]);
    ends_quietly(&["stability", "--list"]);
}

#[test]
fn help_does_not_panic() {
    for arguments in [&["--help"][..], &["compare", "--help"], &["plan", "--help"]] {
        let (_, errors) = unread(arguments, false);
        assert_eq!(errors, "", "{arguments:?}");
    }
}

/// 101 is what a panic ends with.
#[test]
fn errors_that_nobody_reads_do_not_panic() {
    for arguments in [&["compere"][..], &["plan"], &["merge", "s1"]] {
        let (status, _) = unread(arguments, true);
        assert!(
            matches!(status.code(), Some(code) if code != 101 && code != 0),
            "{arguments:?}: {status}"
        );
    }
}
