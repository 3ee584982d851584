//! Progress and formats shared by `plan` and its regret table.

use crate::cli::{cost::time_text, progress::LoggedBar};
use indicatif::ProgressBar;
use std::time::Duration;
use umbrage_plan::Step;

/// Progress of a plan, as lines without a terminal. The number of candidates is not known
/// beforehand, so only tracing moves the bar.
pub(crate) struct PlanProgress(LoggedBar);

impl PlanProgress {
    pub(crate) fn new() -> Self {
        // Print to standard error: a program may read the results.
        let print_line = |bar: &ProgressBar, elapsed: Duration| {
            let gone = time_text(elapsed);
            eprintln!("[{gone}] {}{}", bar.prefix(), bar.message());
        };
        let style = "{bar:30} [{elapsed}]  {prefix}{wide_msg}";
        let shown = LoggedBar::new(1000, style, print_line);
        shown.bar.enable_steady_tick(Duration::from_millis(200));
        Self(shown)
    }

    /// Sets a text that precedes each message.
    pub(crate) fn prefix(&self, text: String) {
        self.0.bar.set_prefix(text);
    }

    /// Shows a step. May be called from any thread.
    pub(crate) fn note(&self, step: Step<'_>) {
        let bar = &self.0.bar;
        match step {
            Step::Looking => bar.set_message("locating regions of varying visibility"),
            Step::Truth(done, total) => {
                bar.set_message("tracing the reference");
                bar.set_position(1000 * done as u64 / total.max(1) as u64);
            }
            Step::Trying(technique, before) => {
                bar.set_message(format!("evaluating {technique} ({before} settings done)"));
            }
            Step::Timing(count) => bar.set_message(format!("timing {count} settings in turn")),
            Step::Explaining => bar.set_message("writing the reasons"),
        }
    }

    /// Prints a line above the bar.
    pub(crate) fn say(&self, line: &str) {
        if self.0.bar.is_hidden() {
            println!("{line}")
        } else {
            self.0.bar.println(line)
        }
    }

    pub(crate) fn finish(&self) {
        self.0.finish();
    }
}

/// Formats a number of bytes: `2.0 KiB`.
pub(crate) fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1024.0 => format!("{bytes} B"),
        b if b < 1024.0 * 1024.0 => format!("{:.1} KiB", b / 1024.0),
        b => format!("{:.1} MiB", b / 1024.0 / 1024.0),
    }
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn bytes_are_readable() {
        assert_eq!([1, 2048, 3 << 20].map(bytes), ["1 B", "2.0 KiB", "3.0 MiB"]);
    }
}
