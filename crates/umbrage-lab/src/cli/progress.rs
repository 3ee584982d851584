//! Shows the progress of a comparison and the remaining time.

use crate::cli::cost::time_text;
use crate::compare::CompareEvent;
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    sync::{
        Mutex,
        mpsc::{RecvTimeoutError, Sender, channel},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

/// Interval of log lines if there is no terminal for a bar.
pub(crate) const LOG_INTERVAL: Duration = Duration::from_secs(30);

/// A progress bar. Without a terminal, a line is printed every [`LOG_INTERVAL`].
pub(crate) struct LoggedBar {
    pub(crate) bar: ProgressBar,
    log: Option<Repeater>,
}

impl LoggedBar {
    /// Returns a bar with this many steps in a style of `indicatif`. `print_line` receives the bar
    /// and the elapsed time.
    pub(crate) fn new(
        steps: u64,
        style: &str,
        print_line: impl Fn(&ProgressBar, Duration) + Send + 'static,
    ) -> Self {
        let style = ProgressStyle::with_template(style);
        let bar = ProgressBar::new(steps)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let start = Instant::now();
        let shown = bar.clone();
        let print_line = move || print_line(&shown, start.elapsed());
        let log = bar
            .is_hidden()
            .then(|| Repeater::new(LOG_INTERVAL, print_line));
        Self { bar, log }
    }

    /// Returns a bar for work in equal steps.
    pub(crate) fn of_steps(message: String, steps: u64) -> Self {
        let print_line = move |bar: &ProgressBar, _: Duration| {
            println!("{}: {} of {steps}", bar.message(), bar.position());
        };
        let out = Self::new(steps, "{wide_bar} {pos}/{len}", print_line);
        out.bar.set_message(message);
        out
    }

    pub(crate) fn finish(&self) {
        if let Some(log) = &self.log {
            log.stop();
        }
        self.bar.finish_and_clear();
    }
}

/// Progress bar of a whole comparison.
pub(crate) struct Progress {
    shown: LoggedBar,
    at: Mutex<Position>,
}

/// Progress of the comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Position {
    /// Work of the scenes before the current one.
    before: u64,
    /// Work of the current scene: half for truth, half for its rows.
    work: u64,
    /// Rows of the current scene.
    rows: u64,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let style = "{bar:30} {percent:>3} %  {elapsed} elapsed, {eta} left  {wide_msg}";
        let print_line = |bar: &ProgressBar, elapsed: Duration| {
            let length = bar.length().unwrap_or(0).max(1);
            let done = bar.position() as f64 / length as f64;
            println!("{}", log_line(done, elapsed, &bar.message()));
        };
        Self {
            shown: LoggedBar::new(0, style, print_line),
            at: Mutex::default(),
        }
    }

    /// Shows an event. May be called from any thread.
    pub(crate) fn note(&self, event: CompareEvent<'_>) {
        // Use the lock after a panic on another thread, too: a second panic would hide the message
        // of the first.
        let mut at = self
            .at
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(message) = message(event) {
            self.shown.bar.set_message(message);
        }
        match event {
            CompareEvent::Started { work, .. } => self.shown.bar.set_length(work),
            CompareEvent::Scene { rows, work, .. } => {
                let before = at.before + at.work;
                *at = Position {
                    before,
                    work,
                    rows: rows as u64,
                };
            }
            _ => {}
        }
        // Print a line for each scene in a log.
        if let CompareEvent::SceneDone { result } = event
            && self.shown.bar.is_hidden()
        {
            println!("{}: {} rows", result.name, result.rows.len());
        }
        if let Some(position) = position(*at, event) {
            self.shown.bar.set_position(position);
        }
    }

    pub(crate) fn finish(&self) {
        self.shown.finish();
    }
}

/// A thread that calls a function at equal intervals until it is stopped.
pub(crate) struct Repeater {
    stop: Mutex<Option<Sender<()>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Repeater {
    pub(crate) fn new(interval: Duration, function: impl Fn() + Send + 'static) -> Self {
        let (stop, stopped) = channel();
        let thread = std::thread::spawn(move || {
            // Wait until the other end of the channel is dropped.
            while stopped.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                function();
            }
        });
        Self {
            stop: Mutex::new(Some(stop)),
            thread: Mutex::new(Some(thread)),
        }
    }

    /// Stops the calls. Waits for one that has begun.
    pub(crate) fn stop(&self) {
        let sender = self.stop.lock().ok().and_then(|mut slot| slot.take());
        drop(sender);
        let thread = self.thread.lock().ok().and_then(|mut slot| slot.take());
        if let Some(thread) = thread {
            // If the thread panicked, its message has been printed.
            drop(thread.join());
        }
    }
}

impl Drop for Repeater {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Returns a line of the log. `done` is the completed share, 0..=1.
fn log_line(done: f64, elapsed: Duration, message: &str) -> String {
    let gone = time_text(elapsed);
    let left = elapsed.as_secs_f64() * (1.0 - done).max(0.0) / done;
    // Estimate the rest only after the first hundredth: less is too little.
    let rest = if done > 0.01 {
        format!(", about {} left", time_text(Duration::from_secs_f64(left)))
    } else {
        String::new()
    };
    format!("{:.0} %, {gone} elapsed{rest}: {message}", 100.0 * done)
}

fn message(event: CompareEvent<'_>) -> Option<String> {
    match event {
        CompareEvent::Scene { name, .. } => Some(format!("{name}: truth")),
        CompareEvent::Row {
            technique,
            settings,
            backend,
            ..
        } => Some(format!("{technique} ({settings}) on {backend}")),
        CompareEvent::Writing => Some("writing the report".to_owned()),
        _ => None,
    }
}

/// Returns the completed steps after an event. `None` if it doesn't change them.
fn position(at: Position, event: CompareEvent<'_>) -> Option<u64> {
    let half = at.work / 2;
    let within = match event {
        CompareEvent::Truth { done, total } => part(half, done, total),
        CompareEvent::Row { index, .. } => half + part(half, index, at.rows as usize),
        CompareEvent::SceneDone { .. } => at.work,
        _ => return None,
    };
    Some(at.before + within)
}

/// Returns the work of `done` of `total` parts.
fn part(work: u64, done: usize, total: usize) -> u64 {
    let share = done as f64 / total.max(1) as f64;
    (work as f64 * share) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    };

    #[test]
    fn truth_is_the_first_half_of_a_scene() {
        let at = Position {
            before: 5000,
            work: 2000,
            rows: 10,
        };
        assert_eq!(
            position(at, CompareEvent::Truth { done: 1, total: 2 }),
            Some(5500)
        );
        let row = CompareEvent::Row {
            technique: "",
            settings: "",
            backend: "",
            index: 5,
        };
        assert_eq!(position(at, row), Some(6500));
    }

    /// No event occurs meanwhile, as during a large row.
    #[test]
    fn a_log_hears_of_progress_though_nothing_happens() {
        let calls = Arc::new(AtomicUsize::new(0));
        let count = calls.clone();
        let repeater = Repeater::new(Duration::from_millis(2), move || {
            count.fetch_add(1, Ordering::Relaxed);
        });
        let start = Instant::now();
        while calls.load(Ordering::Relaxed) < 3 && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        repeater.stop();
        let heard = calls.load(Ordering::Relaxed);
        assert!(heard >= 3);
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(calls.load(Ordering::Relaxed), heard, "stopped");
    }

    #[test]
    fn a_line_says_how_far_it_is() {
        let minutes = |m: u64| Duration::from_secs(60 * m);
        assert_eq!(
            log_line(0.25, minutes(5), "cubes: truth"),
            "25 %, 5 min elapsed, about 15 min left: cubes: truth"
        );
        assert_eq!(
            log_line(0.0, minutes(5), "cubes: truth"),
            "0 %, 5 min elapsed: cubes: truth"
        );
    }
}
