//! A second look at a setting that is about to be chosen, at what the first sample may have missed.
//!
//! The first sample is shared by all settings: what but a few of them do wrong, in places that the pilot did not suspect,
//! it may hardly meet. The second is a setting's own: most of it is drawn where the whole image's mask differs from the
//! pilot.
//!
//! Under ideal lights the pilot is truth, and nowhere else can anything be wrong. Under others its few rays are noise; where
//! a mask's error is none on the whole sample, that only says that few rays have missed what many would find: if `count` of
//! all n rays did find a fault, at most `most(count) / n` of the light may be wrong on average, but for one case in twenty.

use super::{
    density::{Pilot, shared},
    error::{Estimate, ONE_IN_TWENTY, estimate, estimate_of_part},
    sample::Sample,
    scene::{Known, Look},
};
use crate::{
    MeasureError,
    progress::{OnStep, Step},
    truth::TruthOptions,
};
use umbrage_core::Recipe;

/// How many times the first sample second ones are, as long as what they say leaves a bound open: each time with half the
/// uncertainty.
const LOOKS: [usize; 3] = [1, 4, 16];

/// How second samples are drawn.
#[derive(Clone, Debug)]
pub(crate) struct Verifier {
    /// None where no rays can be had.
    pub(crate) pilot: Option<Pilot>,
    pub(crate) truth: TruthOptions,
    /// Receivers.
    pub(crate) count: usize,
    pub(crate) seed: u32,
}

/// A setting that is looked at again.
pub(crate) struct Suspect<'a> {
    pub(crate) recipe: &'a Recipe,
    /// What the first sample says of it.
    pub(crate) first: Estimate,
    /// The greatest error that is wanted, if any.
    pub(crate) bound: Option<f64>,
}

impl Verifier {
    /// The estimate of a setting by samples of its own: the first of [`LOOKS`], and the others as long as the bound is open.
    pub(crate) fn estimate(
        &self,
        look: &mut Look<'_>,
        known: &Known,
        suspect: &Suspect<'_>,
        on_step: &OnStep<'_>,
    ) -> Result<Estimate, MeasureError> {
        let Some(pilot) = &self.pilot else {
            return Ok(unseen_by(known, suspect.first));
        };
        let mask = look.render(suspect.recipe)?;
        let receives = &look.receivers.receives;
        let differences = (0..mask.len()).map(|i| {
            if receives[i] {
                (mask[i] - pilot.mask[i]).abs()
            } else {
                0.0
            }
        });
        let nowhere_else = pilot.is_exact || suspect.first.error == 0.0;
        let density: Vec<f64> = match nowhere_else {
            true => differences.map(|d| f64::from(u8::from(d > 0.0))).collect(),
            false => shared(differences.map(f64::from).collect(), receives),
        };
        let mut found = suspect.first;
        for (k, times) in (0..).zip(LOOKS) {
            let drawn = Sample::draw(
                look.camera.size,
                &density,
                times * self.count,
                self.seed.wrapping_add(k),
            );
            let is_all = drawn.chances.iter().all(|chance| *chance == 1.0);
            let (Known { sample, truth, .. }, there) = self.ask(look, drawn, &mask, on_step)?;
            found = if nowhere_else {
                let wrong = |k: &usize| truth[*k].visibility != there[*k];
                let faults: f64 = (0..there.len())
                    .filter(wrong)
                    .map(|k| 1.0 / sample.chances[k])
                    .sum();
                // Differences are at most 1, so their squares are no greater than they are.
                let rays = f64::from(pilot.rays) * known.counted.most();
                let unseen = if pilot.is_exact || rays == 0.0 {
                    0.0
                } else {
                    most(faults) / rays
                };
                estimate_of_part(&sample, &truth, &there, known.counted, unseen)
            } else {
                estimate(&sample, &truth, &there)
            };
            if is_all
                || suspect
                    .bound
                    .is_none_or(|b| found.is_surely_within(b) || found.is_surely_above(b))
            {
                break;
            }
        }
        Ok(found)
    }

    /// Truth of a sample, and the mask there.
    fn ask(
        &self,
        look: &mut Look<'_>,
        sample: Sample,
        mask: &[f32],
        on_step: &OnStep<'_>,
    ) -> Result<(Known, Vec<f32>), MeasureError> {
        let truth = look.truth(&sample.pixels, &self.truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        let known = Known::new(sample, truth);
        let there = known
            .sample
            .pixels
            .iter()
            .map(|&i| mask[i as usize])
            .collect();
        Ok((known, there))
    }
}

/// Without a pilot the first sample must do; where it has met no fault, as if all that is wrong had the least chance to be
/// drawn.
fn unseen_by(known: &Known, first: Estimate) -> Estimate {
    let least = known.sample.chances.iter().copied().fold(1.0, f64::min);
    let all = known.counted.count;
    if first.error > 0.0 || least == 1.0 || all == 0.0 {
        return first;
    }
    Estimate {
        high: (most(0.0) / (least * all)).sqrt(),
        ..first
    }
}

/// What a count's mean is at most, but for one case in twenty: 3 for none ("rule of three"). Within a hundredth of Poisson's
/// distribution (Byar's approximation: Breslow and Day 1987, "Statistical methods in cancer research", volume 2).
fn most(count: f64) -> f64 {
    let next = count + 1.0;
    next * (1.0 - 1.0 / (9.0 * next) + ONE_IN_TWENTY / (3.0 * next.sqrt())).powi(3)
}

#[cfg(test)]
mod tests {
    use super::most;

    /// Tables of Poisson's distribution: 95 % one-sided.
    #[test]
    fn upper_limits_are_those_of_tables() {
        for (count, limit) in [(0.0, 2.996), (1.0, 4.744), (5.0, 10.513), (20.0, 29.062)] {
            assert!(
                (most(count) / limit - 1.0).abs() < 0.01,
                "{count}: {}",
                most(count)
            );
        }
    }
}
