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
    estimate::{Estimate, ONE_IN_TWENTY, estimate, estimate_of_part},
    look::{Known, Look},
    sample::Sample,
};
use crate::{LabError, truth::TruthOptions};
use umbrage_core::Recipe;

/// How many times the first sample second ones are, as long as what they say leaves a bound open: each time with half the
/// uncertainty.
pub(super) const LOOKS: [usize; 3] = [1, 4, 16];

/// How second samples are drawn.
#[derive(Clone, Debug)]
pub(super) struct Verifier {
    /// None where no rays can be had.
    pub(super) pilot: Option<Pilot>,
    pub(super) truth: TruthOptions,
    /// Receivers.
    pub(super) count: usize,
    pub(super) seed: u32,
}

impl Verifier {
    /// The estimate of a setting whose error on the sample `known` is `error`, by a second one `times` as great.
    pub(super) fn estimate(
        &self,
        look: &mut Look<'_>,
        known: &Known,
        error: f64,
        recipe: &Recipe,
        times: usize,
    ) -> Result<Estimate, LabError> {
        let Some(pilot) = &self.pilot else { return Ok(unseen_by(known)) };
        let mask = look.render(recipe)?;
        let all = known.counted();
        if pilot.is_exact || error == 0.0 {
            let differs = |i: usize| look.receivers.receives[i] && mask[i] != pilot.mask[i];
            let density: Vec<f64> = (0..mask.len()).map(|i| f64::from(u8::from(differs(i)))).collect();
            let (Known { sample, truth }, there) = self.draw(look, &density, &mask, times)?;
            // Differences are at most 1, so their squares are no greater than they are.
            let wrong = |k: &usize| truth[*k].visibility != there[*k];
            let found: f64 = (0..there.len()).filter(wrong).map(|k| 1.0 / sample.chances[k]).sum();
            let unseen = if pilot.is_exact { 0.0 } else { most(found) / (f64::from(pilot.rays) * all) };
            return Ok(estimate_of_part(&sample, &truth, &there, all, unseen));
        }
        let differences = mask.iter().zip(&pilot.mask).map(|(a, b)| f64::from((a - b).abs())).collect();
        let density = shared(differences, &look.receivers.receives);
        let (Known { sample, truth }, there) = self.draw(look, &density, &mask, times)?;
        Ok(estimate(&sample, &truth, &there))
    }

    /// A sample with truth, and the mask there.
    fn draw(
        &self,
        look: &mut Look<'_>,
        density: &[f64],
        mask: &[f32],
        times: usize,
    ) -> Result<(Known, Vec<f32>), LabError> {
        let sample = Sample::draw(look.camera.size, density, times * self.count, self.seed);
        let truth = look.truth(&sample.pixels, &self.truth, &|_, _| {})?;
        let known = Known::new(sample, truth);
        let there = known.sample.pixels.iter().map(|&i| mask[i as usize]).collect();
        Ok((known, there))
    }
}

/// Without a pilot: as if all that is wrong had the least chance to be drawn, and none was.
fn unseen_by(known: &Known) -> Estimate {
    let least = known.sample.chances.iter().copied().fold(1.0, f64::min);
    let all = known.counted();
    let unseen = if least < 1.0 { most(0.0) / (least * all) } else { 0.0 };
    estimate_of_part(&Sample::default(), &[], &[], all, unseen)
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
            assert!((most(count) / limit - 1.0).abs() < 0.01, "{count}: {}", most(count));
        }
    }
}
