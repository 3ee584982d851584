//! Measures the prices of work.

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

/// The work and time of a recipe's part: of what it draws (casts and filters), or of its lookup.
#[derive(Clone, Debug, PartialEq)]
pub struct CostSample {
    /// Scene, technique, settings and part, for people.
    pub label: String,
    /// The part's work.
    pub work: Work,
    /// The part's time, milliseconds: the quickest of the runs.
    pub milliseconds: f64,
}

impl CostSample {
    /// Returns the samples of a recipe's two parts from its whole work; of its lookup alone if it
    /// draws nothing.
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
            work: work.drawing(),
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
    /// Half of the samples are predicted within this factor, 1 or more.
    pub typical_factor: f64,
    /// Nine of ten are within this one.
    pub factor_of_nine_in_ten: f64,
}

/// Plays scenes with settings on a backend, and returns their work and times. Settings that can't
/// serve a scene are left out.
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
        // Built beforehand, as building the hierarchy is no part of a frame.
        let _: &Arc<Bvh> = geometry.bvh();
        for &size in sizes {
            let camera = camera.resized(size);
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

/// Plays a technique and times its parts; none where it isn't supported or too large for the
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
    // Making tables is priced apart, as `Work::listed`.
    recipe.make_tables();
    let mut least_draw = f64::INFINITY;
    let mut least_lookup = f64::INFINITY;
    let mut first_timed = None;
    for run in 0..=runs.max(1) {
        // A card reads masks back for longer than it renders them. Its first runs bring it to its
        // full clock.
        let spent = first_timed.map_or(Duration::ZERO, |start: Instant| start.elapsed());
        let is_enough = spent > LONG || (spent > ENOUGH && run > MIN_RUNS);
        if is_enough && run > 1 {
            break;
        }
        let shadows = match backend.render(view, &recipe) {
            Ok(shadows) => shadows,
            // Its images are larger than this device can hold.
            Err(BackendError::Invalid(_)) => return Ok(Vec::new()),
            Err(e) => return Err(e.into()),
        };
        // The first run compiles and uploads: it doesn't count.
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
    let work = Work::of(view, &recipe, &Catalogue::built_in());
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

/// Rounds in which the fit comes nearer to the least sum of squared logarithms.
const ROUNDS: usize = 12;

/// Fits prices to measurements, so that the sum of the squared logarithms of predicted over
/// measured time is least: a factor of two matters as much at a tenth of a millisecond as at a
/// hundred, and half the time as much as twice the time. By Gauss and Newton's method: around the
/// last prediction p, log p is a line, whose least squares are solved for.
pub fn fit(samples: Vec<CostSample>) -> Calibration {
    // A row is what each kind of work adds to the predicted time for a price of 1 ns, relative to
    // the measured time. The sum of price times row is then predicted over measured time, which is
    // to be 1.
    let mut rows = Vec::with_capacity(samples.len());
    for sample in &samples {
        let measured = sample.milliseconds.max(MIN_MILLISECONDS);
        rows.push(counts(&sample.work).map(|count| count * 1e-6 / measured));
    }
    let mut nanoseconds = solve(&rows, &vec![1.0; rows.len()]);
    for _ in 0..ROUNDS {
        let mut scaled = Vec::with_capacity(rows.len());
        let mut targets = Vec::with_capacity(rows.len());
        for row in &rows {
            let products = row.iter().zip(nanoseconds).map(|(r, price)| r * price);
            let predicted = products.sum::<f64>().max(MIN_RATIO);
            // log q = log p + (q - p) / p is to be 0: q / p is to be 1 - log p. Far above, a step
            // stays within the prices' signs.
            targets.push((1.0 - predicted.ln()).max(MIN_TARGET));
            scaled.push(row.map(|r| r / predicted));
        }
        nanoseconds = solve(&scaled, &targets);
    }
    let model = CostModel { nanoseconds };
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

/// The least ratio of predicted to measured time whose logarithm is followed.
const MIN_RATIO: f64 = 1e-3;

/// The least share of a prediction that one round aims at.
const MIN_TARGET: f64 = 0.05;

/// A setting that has been timed for so long and [`MIN_RUNS`] times is not timed again, so that
/// some 600 settings take about a minute on a card.
const ENOUGH: Duration = Duration::from_millis(40);

/// Timed runs of a setting, of which the quickest counts.
const MIN_RUNS: u32 = 3;

/// A setting that has been timed for so long is not timed again.
const LONG: Duration = Duration::from_secs(1);

/// The least time that is divided by, milliseconds: a step of the clock.
const MIN_MILLISECONDS: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::KINDS;

    /// Work of many kinds, in amounts that are not in proportion.
    fn works() -> Vec<Work> {
        let mix = |i: u64, k: u64| (i * 7919 + k * 104_729) % 1000 * 10u64.pow((k % 3) as u32) + 1;
        let work = |i| Work {
            listed: 0,
            passes: mix(i, 0) % 7 + 1,
            triangles: mix(i, 1),
            covered: mix(i, 2),
            // At other steps than the others, or it would be in proportion to triangles, nearly.
            cut_out: mix(7 * i, 12),
            cleared: mix(i, 3),
            filtered: mix(i, 4),
            filter_taps: mix(i, 11),
            receivers: mix(i, 5),
            taps: mix(i, 6),
            samples: mix(i, 8),
            rays: mix(i, 7),
            casters: 64,
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
                900.0, 20.0, 3.0, 1.0, 6.0, 5.0, 2.0, 12.0, 40.0, 90.0, 4.0, 7.0, 11.0,
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
    fn times_that_are_no_sum_of_work_are_told_by_the_factor() {
        let mut spoilt = samples(&CostModel::CPU);
        spoilt
            .iter_mut()
            .step_by(2)
            .for_each(|s| s.milliseconds *= 5.0);
        assert!(fit(spoilt).factor_of_nine_in_ten > 1.5);
    }
}
