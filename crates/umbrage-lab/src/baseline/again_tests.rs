//! Whole comparisons with a simulated clock that slows one row down.

use super::*;
use crate::{
    baseline::{changes, except::Except},
    compare::{Comparison, compare},
};
use glam::UVec2;
use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};
use umbrage_core::{Backend, BackendError, Recipe, Shadows, Timings, View};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::TruthOptions;

/// A clock on which the row of this map size takes `factor` times its usual time.
#[derive(Debug)]
struct Clock {
    slow_map: u32,
    factor: f64,
    /// The number of renderings of the row since the factor was set.
    renders: u32,
}

impl Clock {
    /// Sets the factor and restarts the count of renderings.
    fn set(&mut self, factor: f64) {
        self.factor = factor;
        self.renders = 0;
    }
}

/// A clock shared by a backend and its test.
type SharedClock = Arc<Mutex<Clock>>;

fn lock(clock: &SharedClock) -> std::sync::MutexGuard<'_, Clock> {
    clock.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Clocked {
    cpu: Cpu,
    clock: SharedClock,
}

impl Backend for Clocked {
    fn name(&self) -> &str {
        "a clock"
    }
    fn kind(&self) -> &'static str {
        "cpu"
    }
    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        let mut shadows = self.cpu.render(view, recipe)?;
        let uniforms = recipe.receive.kernel.uniforms();
        let is_yardstick = uniforms.is_some_and(|u| u.uniform_layout().name == "YardstickUniforms");
        let mut clock = lock(&self.clock);
        let is_slow = recipe
            .images
            .first()
            .is_some_and(|image| image.size.x == clock.slow_map);
        let mut milliseconds = 3.0;
        if is_slow && !is_yardstick {
            milliseconds *= clock.factor;
            clock.renders += 1;
        }
        let took = Some(Duration::from_secs_f64(milliseconds * 1e-3));
        shadows.timings = Timings {
            receive: took,
            ..Timings::default()
        };
        Ok(shadows)
    }
}

struct RetimeFixture {
    inputs: Vec<SceneInput>,
    options: CompareOptions,
    backends: Backends,
    clock: SharedClock,
}

/// Hard shadows from maps of three sizes, on two scenes.
fn stage() -> RetimeFixture {
    let clock = Arc::new(Mutex::new(Clock {
        slow_map: 48,
        factor: 1.0,
        renders: 0,
    }));
    let input = |name: &str| {
        let scene = (umbrage_scenes::find(name).expect("built in").build)();
        SceneInput::new(scene, "")
    };
    let options = CompareOptions {
        catalogue: umbrage_plan::catalogue::Catalogue::built_in(),
        techniques: vec!["hard".to_owned()],
        map_sizes: vec![48, 64, 80],
        max_settings: Some(3),
        size: Some(UVec2::new(24, 16)),
        truth: TruthOptions {
            samples: 4,
            probe_samples: 4,
            ..TruthOptions::default()
        },
        runs: Some(Runs::exactly(9)),
        color: false,
        ..CompareOptions::default()
    };
    let own_backend: Box<dyn Backend + Send> = Box::new(Clocked {
        cpu: Cpu::new(),
        clock: Arc::clone(&clock),
    });
    RetimeFixture {
        inputs: vec![input("figure"), input("cubes")],
        options,
        backends: Backends::from_backends(vec![own_backend]),
        clock,
    }
}

impl RetimeFixture {
    fn compare(&mut self) -> Comparison {
        compare(
            &self.inputs,
            &self.options,
            &mut self.backends,
            &mut |_, _| Ok(()),
            &|_| (),
        )
        .expect("valid")
    }

    /// Returns the changes of a run in which the row takes `first` times as long as in the
    /// baseline, and `later` times as long when it is timed again.
    fn guard(&mut self, first: f64, later: f64) -> crate::baseline::changes::Changes {
        lock(&self.clock).set(1.0);
        let old = self.compare();
        lock(&self.clock).set(first);
        let new = self.compare();
        let mut found = changes(&old, &new, &Except::default());
        assert!(found.worse.is_empty() && found.timed == 6, "{found:?}");
        lock(&self.clock).set(later);
        time_again(&mut found, &self.inputs, &self.options, &mut self.backends).expect("valid");
        assert!(found.suspects.is_empty(), "all suspects are decided");
        found
    }
}

#[test]
fn a_row_slowed_down_by_two_is_caught_and_no_other() {
    let found = stage().guard(2.0, 2.0);
    assert_eq!(found.worse.len(), 2, "in both scenes: {found:?}");
    for (line, scene) in found.worse.iter().zip(["figure", "cubes"]) {
        assert!(line.starts_with(&format!("{scene}: hard (48,")), "{line}");
        assert!(line.contains("slower by a factor of 2.00"), "{line}");
    }
}

#[test]
fn what_is_as_quick_as_before_when_timed_again_is_no_alarm() {
    let mut stage = stage();
    let found = stage.guard(2.0, 1.0);
    assert!(
        found.worse.is_empty() && found.notes.len() == 1,
        "{found:?}"
    );
    assert!(
        found.notes[0].contains("timed again: 0 are slower"),
        "{found:?}"
    );
    // One round clears it: in each scene a warm-up run and nine to fifteen counted runs.
    assert!(
        (20..=32).contains(&lock(&stage.clock).renders),
        "{}",
        lock(&stage.clock).renders
    );
}

#[test]
fn unchanged_rows_are_not_timed_again() {
    let mut stage = stage();
    let found = stage.guard(1.0, 1.0);
    assert!(
        found.worse.is_empty() && found.notes.is_empty() && lock(&stage.clock).renders == 0,
        "{found:?}"
    );
}
