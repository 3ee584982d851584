//! Measurement of the prices of work.

use super::{CostModel, counts, least_squares::solve, work::Work};
use crate::{catalogue::Catalogue, error::MeasureError, statistics::Sorted};
use glam::UVec2;
use std::{
    sync::Arc,
    time::{Duration, Instant},
};
use umbrage_core::{
    Backend, BackendError, Bvh, Geometry, RecipeError, Scene, ShadowTechnique as _, View,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::TechniquePreset;

/// Work and time of one part of a recipe: its casts and filters, or its lookup.
#[derive(Clone, Debug, PartialEq)]
pub struct CostSample {
    /// Display label: scene, technique, settings and part.
    pub label: String,
    /// The part's work.
    pub work: Work,
    /// The part's time, milliseconds: the fastest of the runs.
    pub milliseconds: f64,
}

impl CostSample {
    /// Returns the samples of a recipe's two parts from its total work, or only that of its lookup
    /// if it draws nothing.
    pub fn of_parts(label: &str, work: &Work, draw_ms: f64, lookup_ms: f64) -> Vec<Self> {
        let lookup = Self {
            label: format!("{label}, lookup"),
            work: work.lookup(),
            milliseconds: lookup_ms,
        };
        if work.passes < 2 {
            return vec![lookup];
        }
        let draw = Self {
            label: format!("{label}, drawing"),
            work: work.drawing_only(),
            milliseconds: draw_ms,
        };
        vec![draw, lookup]
    }
}

/// Prices, and the measurements that they are fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The prices.
    pub model: CostModel,
    /// The measurements.
    pub samples: Vec<CostSample>,
    /// Factor within which half of the samples are predicted, 1 or more.
    pub typical_factor: f64,
    /// Factor within which nine of ten samples are predicted.
    pub factor_of_nine_in_ten: f64,
}

/// Runs scenes with settings on a backend, and returns their work and times. Skips settings that
/// don't support a scene.
///
/// # Errors
/// Errors if a scene or a setting is not valid, or the backend fails.
pub fn time_work(
    backend: &mut dyn Backend,
    scenes: &[Scene],
    sizes: &[UVec2],
    settings: &[TechniquePreset],
    runs: u32,
    on_setting: &mut dyn FnMut(),
) -> Result<Vec<CostSample>, MeasureError> {
    let mut samples = Vec::new();
    for scene in scenes {
        let geometry = Geometry::bake(scene)?;
        let (Some(camera), Some(light)) = (scene.cameras.first(), scene.lights.first()) else {
            continue;
        };
        // Build the hierarchy first, since this is not part of a frame.
        let _: &Arc<Bvh> = geometry.bvh();
        for &size in sizes {
            let camera = camera.with_size(size);
            let receivers = Cpu::new().receivers(&camera, &geometry)?;
            let view = View::new(&camera, light, &geometry).with_receivers(&receivers);
            for technique in settings {
                on_setting();
                let place = format!("{} {size}", scene.name);
                samples.extend(measure(backend, &view, technique, runs, &place)?);
            }
        }
    }
    Ok(samples)
}

/// Runs a technique and times its parts. Returns nothing if it is unsupported or too large for the
/// backend.
fn measure(
    backend: &mut dyn Backend,
    view: &View<'_>,
    technique: &TechniquePreset,
    runs: u32,
    place: &str,
) -> Result<Vec<CostSample>, MeasureError> {
    let recipe = match technique.recipe(view) {
        Ok(recipe) => recipe,
        Err(RecipeError::Unsupported(_)) => return Ok(Vec::new()),
        Err(e) => return Err(e.into()),
    };
    // The CPU queries lists instead: its time is not that of the counted work.
    if recipe.hierarchy.is_some() && backend.kind() == "cpu" {
        return Ok(Vec::new());
    }
    // Tables are priced separately, as `Work::listed`.
    recipe.make_tables();
    let mut least_draw = f64::INFINITY;
    let mut least_lookup = f64::INFINITY;
    let mut first_timed = None;
    for run in 0..=runs.max(1) {
        // Stop early: a GPU spends more time on reading masks back than on rendering. Its first
        // runs bring it to its full clock.
        let spent = first_timed.map_or(Duration::ZERO, |start: Instant| start.elapsed());
        let is_enough = spent > LONG || (spent > ENOUGH && run > MIN_RUNS);
        if is_enough && run > 1 {
            break;
        }
        let shadows = match backend.render(view, &recipe) {
            Ok(shadows) => shadows,
            // Its images exceed the device's limits.
            Err(BackendError::Invalid(_)) => return Ok(Vec::new()),
            Err(e) => return Err(e.into()),
        };
        // Skip the first run, which compiles and uploads.
        if run == 0 {
            first_timed = Some(Instant::now());
        } else {
            let timings = shadows.timings;
            let lookup = timings.receive.unwrap_or_default();
            let draw = timings.total().saturating_sub(lookup);
            least_draw = least_draw.min(milliseconds(draw));
            least_lookup = least_lookup.min(milliseconds(lookup));
        }
    }
    let label = format!("{place} {} ({})", technique.name(), technique.settings());
    let work = Work::of_recipe(view, &recipe, &Catalogue::built_in());
    Ok(CostSample::of_parts(
        &label,
        &work,
        least_draw,
        least_lookup,
    ))
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Number of rounds in which the fit approaches the least sum of squared logarithms.
const ROUNDS: usize = 12;

/// Fits prices to measurements by minimizing the sum of the squared logarithms of predicted over
/// measured time.
///
/// A factor of two thus counts the same at a tenth of a millisecond as at a hundred, and half the
/// time as much as twice the time. Uses the Gauss-Newton method: around the last prediction p, log
/// p is linear, and each round solves a least squares problem.
pub fn fit(samples: Vec<CostSample>) -> Calibration {
    // A row is the contribution of each kind of work to the predicted time at a price of 1 ns,
    // relative to the measured time. The sum of price times row is then the ratio of predicted to
    // measured time, whose target is 1.
    let mut rows = Vec::with_capacity(samples.len());
    for sample in &samples {
        let measured = sample.milliseconds.max(MIN_MILLISECONDS);
        rows.push(counts(&sample.work).map(|count| count * 1e-6 / measured));
    }
    let mut nanoseconds = solve(&rows, &vec![1.0; rows.len()]);
    // Improve the prices round by round.
    for _ in 0..ROUNDS {
        let mut scaled = Vec::with_capacity(rows.len());
        let mut targets = Vec::with_capacity(rows.len());
        for row in &rows {
            let products = row.iter().zip(nanoseconds).map(|(r, price)| r * price);
            let predicted = products.sum::<f64>().max(MIN_RATIO);
            // The target is log q = log p + (q - p) / p = 0, so q / p = 1 - log p. The limit keeps
            // steps from far above within the prices' signs.
            targets.push((1.0 - predicted.ln()).max(MIN_TARGET));
            scaled.push(row.map(|r| r / predicted));
        }
        nanoseconds = solve(&scaled, &targets);
    }
    let model = CostModel { nanoseconds };
    // Compare the predictions with the measurements.
    let mut factors = Vec::with_capacity(samples.len());
    for sample in &samples {
        let predicted = model.milliseconds(&sample.work);
        let ratio = predicted / sample.milliseconds.max(MIN_MILLISECONDS);
        factors.push(ratio.max(1.0 / ratio.max(1e-9)));
    }
    let factors = Sorted::new(factors);
    let typical_factor = factors.quantile(0.5).unwrap_or(1.0);
    let factor_of_nine_in_ten = factors.quantile(0.9).unwrap_or(1.0);
    Calibration {
        model,
        samples,
        typical_factor,
        factor_of_nine_in_ten,
    }
}

/// Least ratio of predicted to measured time whose logarithm is used.
const MIN_RATIO: f64 = 1e-3;

/// Least share of a prediction that one round can target.
const MIN_TARGET: f64 = 0.05;

/// Time after which a setting is not run again once it has [`MIN_RUNS`] runs. Some 600 settings
/// then take about a minute on a GPU.
const ENOUGH: Duration = Duration::from_millis(40);

/// Number of timed runs of a setting, of which the fastest counts.
const MIN_RUNS: u32 = 3;

/// Time after which a setting is not run again.
const LONG: Duration = Duration::from_secs(1);

/// Least time used as a divisor, milliseconds: a step of the clock.
const MIN_MILLISECONDS: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::KINDS;

    /// Returns work of many kinds, in amounts that are not proportional.
    fn works() -> Vec<Work> {
        let mix = |i: u64, k: u64| (i * 7919 + k * 104_729) % 1000 * 10u64.pow((k % 3) as u32) + 1;
        let work = |i| Work {
            listed: 0,
            passes: mix(i, 0) % 7 + 1,
            triangles: mix(i, 1),
            covered: mix(i, 2),
            // Uses other steps than the rest, otherwise it would be nearly proportional to
            // triangles.
            cut_out: mix(7 * i, 12),
            cleared: mix(i, 3),
            filtered: mix(i, 4),
            filter_taps: mix(i, 11),
            receivers: mix(i, 5),
            taps: mix(i, 6),
            samples: mix(i, 8),
            rays: mix(i, 7),
            casters: 64,
            placed: mix(11 * i, 13),
            walks: mix(13 * i, 14),
            faces: mix(i, 9),
            counted: mix(i, 10),
            bytes: 0,
        };
        (0..60).map(work).collect()
    }

    fn samples(model: &CostModel) -> Vec<CostSample> {
        let sample = |work: Work| CostSample {
            label: String::new(),
            milliseconds: model.milliseconds(&work),
            work,
        };
        works().into_iter().map(sample).collect()
    }

    #[test]
    fn known_prices_are_found_again() {
        let known = CostModel {
            nanoseconds: [
                900.0, 20.0, 3.0, 1.0, 6.0, 5.0, 2.0, 12.0, 40.0, 90.0, 4.0, 7.0, 11.0, 30.0, 8.0,
            ],
        };
        let found = fit(samples(&known));
        assert!(
            found.factor_of_nine_in_ten < 1.001,
            "{}",
            found.factor_of_nine_in_ten
        );
        for k in 0..KINDS {
            let found = found.model.nanoseconds[k];
            let known = known.nanoseconds[k];
            assert!(
                (found / known - 1.0).abs() < 0.01,
                "{k}: {found} for {known}"
            );
        }
    }

    #[test]
    fn times_that_are_no_sum_of_work_are_found_by_the_factor() {
        let mut spoilt = samples(&CostModel::CPU);
        spoilt
            .iter_mut()
            .step_by(2)
            .for_each(|s| s.milliseconds *= 5.0);
        assert!(fit(spoilt).factor_of_nine_in_ten > 1.5);
    }
}
