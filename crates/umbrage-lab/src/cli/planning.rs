//! Progress and formats that `plan` and its regret table share.

use crate::cli::{
    cost::spoken,
    progress::{LOG_INTERVAL, Repeater},
};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};
use umbrage_plan::Step;

/// The progress of a plan; lines without a terminal. How many candidates it tries is not known beforehand, so only tracing truth moves
/// the bar.
pub(crate) struct Progress {
    bar: ProgressBar,
    log: Option<Repeater>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let style = ProgressStyle::with_template("{bar:30} {elapsed} gone  {prefix}{wide_msg}");
        let bar = ProgressBar::new(1000)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(200));
        let start = Instant::now();
        let shown = bar.clone();
        // Not among the results, which may be read by a program.
        let print_line = move || {
            let gone = spoken(start.elapsed());
            eprintln!("{gone} gone: {}{}", shown.prefix(), shown.message());
        };
        let log = bar
            .is_hidden()
            .then(|| Repeater::new(LOG_INTERVAL, print_line));
        Self { bar, log }
    }

    /// Sets a text before each message.
    pub(crate) fn prefix(&self, text: String) {
        self.bar.set_prefix(text);
    }

    /// Shows a step; may be called from any thread.
    pub(crate) fn note(&self, step: Step<'_>) {
        match step {
            Step::Looking => self.bar.set_message("looking for where visibility varies"),
            Step::Truth(done, total) => {
                self.bar.set_message("tracing truth");
                self.bar
                    .set_position(1000 * done as u64 / total.max(1) as u64);
            }
            Step::Trying(technique, before) => self
                .bar
                .set_message(format!("trying {technique} ({before} tried)")),
            Step::Timing(count) => self
                .bar
                .set_message(format!("timing {count} settings in turn")),
            Step::Explaining => self.bar.set_message("writing down why"),
        }
    }

    /// Prints a line above the bar.
    pub(crate) fn say(&self, line: &str) {
        if self.bar.is_hidden() {
            println!("{line}")
        } else {
            self.bar.println(line)
        }
    }

    pub(crate) fn finish(&self) {
        if let Some(log) = &self.log {
            log.stop();
        }
        self.bar.finish_and_clear();
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
