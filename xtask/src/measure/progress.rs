//! How far a comparison is, and how long it still takes.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;
use umbrage_lab::compare::Event;

/// Steps of one scene: half for truth, half for its rows.
const STEPS: u64 = 2_000;

/// A bar for the whole comparison.
pub(super) struct Progress {
    bar: ProgressBar,
    at: Mutex<Place>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Place {
    scene: u64,
    rows: u64,
}

impl Progress {
    pub(super) fn new() -> Self {
        let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {elapsed} gone, {eta} to go  {wide_msg}");
        let bar = ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar, at: Mutex::default() }
    }

    /// Takes note of what happens; from any thread.
    pub(super) fn note(&self, event: Event<'_>) {
        // A panic elsewhere must not hide behind the bar's.
        let mut at = self.at.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(message) = message(event) {
            self.bar.set_message(message);
        }
        match event {
            Event::Started { scenes, rows_per_scene } => {
                self.bar.set_length(scenes as u64 * STEPS);
                at.rows = rows_per_scene as u64;
            }
            Event::Scene { index, .. } => at.scene = index as u64,
            _ => {}
        }
        // Where nobody watches, a line a scene shows in the log that there is progress.
        if let (Event::SceneDone { result }, true) = (event, self.bar.is_hidden()) {
            println!("{}: {} rows", result.name, result.rows.len());
        }
        if let Some(position) = position(*at, event) {
            self.bar.set_position(position);
        }
    }

    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn message(event: Event<'_>) -> Option<String> {
    match event {
        Event::Scene { name, .. } => Some(format!("{name}: truth")),
        Event::Row { technique, settings, backend, .. } => Some(format!("{technique} ({settings}) on {backend}")),
        Event::Writing => Some("writing the report".to_owned()),
        _ => None,
    }
}

/// Steps done once this has happened.
fn position(at: Place, event: Event<'_>) -> Option<u64> {
    let half = |done: u64, total: u64| STEPS / 2 * done / total.max(1);
    let within = match event {
        Event::Truth { done, total } => half(done as u64, total as u64),
        Event::Row { index, .. } => STEPS / 2 + half(index as u64, at.rows),
        Event::SceneDone { .. } => STEPS,
        _ => return None,
    };
    Some(at.scene * STEPS + within)
}

#[cfg(test)]
mod tests {
    use super::{Place, STEPS, position};
    use umbrage_lab::compare::Event;

    #[test]
    fn truth_is_the_first_half_of_a_scene() {
        let at = Place { scene: 3, rows: 10 };
        assert_eq!(position(at, Event::Truth { done: 1, total: 2 }), Some(3 * STEPS + STEPS / 4));
        let row = Event::Row { technique: "", settings: "", backend: "", index: 5 };
        assert_eq!(position(at, row), Some(3 * STEPS + STEPS * 3 / 4));
    }
}
