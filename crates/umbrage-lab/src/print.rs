//! `println!` and `eprintln!` of this program. The standard ones panic if the reader closes the
//! pipe, as after `| head`. These end the program silently, on Unix and on Windows.

use std::{
    fmt::Arguments,
    io::{ErrorKind, Write},
};

/// Exit code after writing into a closed pipe: 128 + 13, as shells report for SIGPIPE. It is not 0,
/// as the program did not complete.
const CLOSED_PIPE: i32 = 141;

macro_rules! println {
    () => {
        $crate::print::line(std::io::stdout().lock(), format_args!(""))
    };
    ($($text:tt)*) => {
        $crate::print::line(std::io::stdout().lock(), format_args!($($text)*))
    };
}

macro_rules! eprintln {
    ($($text:tt)*) => {
        $crate::print::line(std::io::stderr().lock(), format_args!($($text)*))
    };
}

/// Writes a line. Ends the program on failure: errors such as a full disk can only be reported by
/// the exit code.
pub(crate) fn line(to: impl Write, text: Arguments<'_>) {
    if let Err(kind) = write(to, text) {
        std::process::exit(if kind == ErrorKind::BrokenPipe {
            CLOSED_PIPE
        } else {
            1
        });
    }
}

fn write(mut to: impl Write, text: Arguments<'_>) -> Result<(), ErrorKind> {
    // Write each line at once, so that lines of several threads don't mix.
    let text = format!("{text}\n");
    to.write_all(text.as_bytes())
        .and_then(|()| to.flush())
        .map_err(|e| e.kind())
}

#[cfg(test)]
mod tests {
    use super::write;
    use std::io::ErrorKind;

    #[test]
    fn lines_arrive_whole_and_closed_pipes_are_reported() {
        let mut bytes = Vec::new();
        assert_eq!(write(&mut bytes, format_args!("{} of {}", 1, 2)), Ok(()));
        assert_eq!(bytes, b"1 of 2\n");
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        assert_eq!(
            write(writer, format_args!("unread")),
            Err(ErrorKind::BrokenPipe)
        );
    }
}
