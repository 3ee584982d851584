//! Rows on a device whose clock falls when it is idle, and at random times.

use super::*;
use std::{any::Any, sync::Arc, time::Duration};
use umbrage_core::{
    Backend, BackendError, ReceiveKernel, Recipe, Shadows, Snapping, Timings, View, glam::UVec2,
    light_sample::hash,
};
use umbrage_cpu::Cpu;
use umbrage_plan::{
    catalogue::Catalogue,
    cost::{PriceList, Work},
    truth::TruthOptions,
};
use umbrage_yardstick::YardstickKernel;

/// Slowdown while the clock is low.
const SLOWDOWN: f64 = 4.0;
/// Number of renders after which an idle device reaches its full clock.
const RENDERS_TO_WARM: u32 = 10;
/// Number of renders of a spell at a low clock, or between two spells.
const SPELL: std::ops::Range<u32> = 2..150;

/// The CPU backend under wgpu's name.
///
/// Its times are predicted costs, multiplied by [`SLOWDOWN`] while its clock is low. It is idle
/// before each new row, so that no wall time decides its clock.
struct ThrottledBackend {
    cpu: Cpu,
    prices: PriceList,
    /// Spells so far.
    spells: u32,
    /// The row rendered last.
    row: Option<Arc<dyn ReceiveKernel>>,
    /// Renders until it reaches its full clock.
    cold: u32,
    /// Renders until the spell ends.
    spell: u32,
    is_low: bool,
}

impl ThrottledBackend {
    fn new() -> Self {
        Self {
            cpu: Cpu::new(),
            prices: PriceList::default(),
            spells: 0,
            row: None,
            cold: RENDERS_TO_WARM,
            spell: 0,
            is_low: false,
        }
    }

    /// Returns the factor of the next render's time.
    fn slowdown(&mut self, kernel: &Arc<dyn ReceiveKernel>) -> f64 {
        let is_yardstick = as_yardstick(&**kernel).is_some();
        let is_same_row = self
            .row
            .as_ref()
            .is_some_and(|row| Arc::ptr_eq(row, kernel));
        if !is_yardstick && !is_same_row {
            self.row = Some(Arc::clone(kernel));
            self.cold = RENDERS_TO_WARM;
        }
        if self.spell == 0 {
            self.spell = SPELL.start + hash(self.spells) % (SPELL.end - SPELL.start);
            self.spells += 1;
            self.is_low = !self.is_low;
        }
        let is_slow = self.is_low || self.cold > 0;
        self.spell -= 1;
        self.cold = self.cold.saturating_sub(1);
        if is_slow { SLOWDOWN } else { 1.0 }
    }
}

impl Backend for ThrottledBackend {
    fn name(&self) -> &str {
        "a throttled device"
    }

    fn kind(&self) -> &'static str {
        "wgpu"
    }

    fn snapping(&self) -> Snapping {
        Snapping::default()
    }

    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        let slowdown = self.slowdown(&recipe.receive.kernel);
        let mut shadows = self.cpu.render(view, recipe)?;
        let mut work = Work::of_recipe(view, recipe, &Catalogue::built_in()).without_lists();
        if let Some(yardstick) = as_yardstick(&*recipe.receive.kernel) {
            work.taps = work.receivers * u64::from(yardstick.uniforms.links);
        }
        let milliseconds = slowdown * self.prices.model_for_backend("wgpu").milliseconds(&work);
        shadows.timings = Timings {
            receive: Some(Duration::from_secs_f64(milliseconds / 1e3)),
            ..Timings::default()
        };
        Ok(shadows)
    }
}

/// Returns a kernel as that of the yardstick. `None` if it is another one.
fn as_yardstick(kernel: &dyn ReceiveKernel) -> Option<&YardstickKernel> {
    let kernel: &dyn Any = kernel;
    kernel.downcast_ref()
}

/// Returns Kendall's tau of some pairs: the share of pairs of pairs in the same order minus that in
/// the opposite order. Pairs with equal first figures are skipped (Kendall 1938, "A new measure of
/// rank correlation").
fn kendall_tau(pairs: &[[f64; 2]]) -> f64 {
    let mut sum = 0.0;
    let mut count = 0.0;
    for (i, a) in pairs.iter().enumerate() {
        for b in &pairs[..i] {
            if a[0] != b[0] {
                sum += ((a[0] - b[0]) * (a[1] - b[1])).signum();
                count += 1.0;
            }
        }
    }
    sum / count
}

#[test]
fn kendall_tau_counts_pairs() {
    assert_eq!(kendall_tau(&[[1.0, 5.0], [2.0, 6.0], [3.0, 7.0]]), 1.0);
    assert_eq!(kendall_tau(&[[1.0, 7.0], [2.0, 6.0], [3.0, 5.0]]), -1.0);
    assert_eq!(kendall_tau(&[[1.0, 1.0], [1.0, 9.0], [2.0, 5.0]]), 0.0);
}

#[test]
fn ranks_at_full_clock_are_those_without_throttling() {
    let entry = umbrage_scenes::find("cubes").expect("built in");
    let input = SceneInput::new((entry.build)(), entry.summary);
    let options = CompareOptions {
        techniques: ["hard", "pcf", "pcf_disc", "pcss", "vsm", "evsm", "traced"]
            .map(str::to_owned)
            .to_vec(),
        map_sizes: vec![128, 256],
        max_settings: None,
        size: Some(UVec2::new(64, 48)),
        truth: TruthOptions {
            samples: 16,
            probe_samples: 8,
            ..TruthOptions::default()
        },
        ..CompareOptions::default()
    };
    let mut backends = Backends::from_backends(vec![Box::new(ThrottledBackend::new())]);
    let comparison = compare(
        &[input],
        &options,
        &mut backends,
        &mut |_, _| Ok(()),
        &|_| (),
    )
    .expect("valid");
    let scene = &comparison.scenes[0];
    let mut plain = Vec::new();
    let mut at_full_clock = Vec::new();
    let mut without_yardstick = Vec::new();
    for row in &scene.rows {
        let Some(m) = row.measured_figures() else {
            continue;
        };
        let truth = m.executed_cost_ms.expect("counted");
        let times = m.times.expect("asked for");
        if times.full_clock_factor.is_none() {
            without_yardstick.push(row.label());
        }
        plain.push([truth, times.total.median]);
        at_full_clock.push([truth, times.milliseconds(&times.total)]);
    }
    assert!(plain.len() >= 40, "only {} rows", plain.len());
    // A spell may begin or end in all runs of a row, which then has no steady yardstick. This
    // happened in none of 14 runs of this test, 8 of them with six busy programs. One row in twenty
    // is allowed.
    assert_eq!(scene.rows_at_unknown_clock(), without_yardstick.len());
    assert!(
        without_yardstick.len() <= 2,
        "rows without a steady yardstick: {without_yardstick:?}"
    );
    let [plain, at_full_clock] = [plain, at_full_clock].map(|pairs| kendall_tau(&pairs));
    println!("tau: {plain:.3} as measured, {at_full_clock:.3} at full clock");
    // Tau was 1.000 in these runs, and 0.32 to 0.89 as measured. A spell that begins and ends
    // within a run is not detected: 0.95 allows one pair of rows in forty in the wrong order.
    assert!(
        at_full_clock >= 0.95,
        "tau {at_full_clock:.3} at full clock"
    );
    assert!(
        plain < at_full_clock,
        "the device was not throttled: tau {plain:.3}"
    );
}
