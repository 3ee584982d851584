//! How well another backend agrees with the CPU.
//!
//! Devices move vertices to grids of 1/16 to 1/256 pixels, and some lay depth planes through the
//! moved ones. That alone moves edges, of shadows and of what is seen. So the CPU executes the
//! recipe once more, rounding vertices as the other backend's device does ([`Snapping`]), and that
//! is what the other backend must agree with: on other grids the same answers are decided, no
//! fewer.

use crate::{compare::nudges::nudges, error::LabError};
use umbrage_core::{
    Backend, Receivers, Recipe, Shadows, Snapping, View,
    metrics::{AGREEMENT_TOLERANCE, Agreement, Doubt},
};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_techniques::sampler_tolerance;

/// A device may differ by so many times what the CPU's answer changes by: it rounds all at once,
/// and several taps of a filter may change together.
const MOST_CHANGES: f32 = 4.0;

/// Returns the same for a recipe. There is no bound for images that filters made: `msm` of 16 bits
/// with little bias makes 40,000 times the change out of another rounding of its quotients.
fn most_changes(recipe: &Recipe) -> f32 {
    if recipe.filters.is_empty() {
        MOST_CHANGES
    } else {
        f32::INFINITY
    }
}

/// Compares a backend's mask with the one that the CPU makes when it rounds vertices so, too.
/// `of_cpu` is what it makes of the same recipe by its own rule; [`Agreement::differing`] and
/// [`Agreement::largest`] tell the difference from that.
///
/// Pixels where the two see different triangles are set apart. Others that differ by more than is
/// allowed are *undecided* if the CPU's answer changes by a quarter as much or more as something
/// moves by what rounding may come to (`nudges.rs`); where images are filtered, if it changes at
/// all. Else they are violations. Equal masks need no nudges, so none are rendered for them.
///
/// # Errors
/// Errors if the CPU can't execute the recipe, or masks differ in size or hold anything outside
/// 0..=1.
pub fn agree(
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    other: &Shadows,
    snapping: Snapping,
) -> Result<Agreement, LabError> {
    let mut cpu = Cpu::with_options(&CpuOptions::default().snapping(snapping))?;
    let played = if snapping == cpu_rule() {
        None
    } else {
        Some(cpu.render(view, recipe)?)
    };
    let expected = played.as_ref().unwrap_or(of_cpu);
    let tolerance = sampler_tolerance(&*recipe.receive.kernel);
    let mut doubts = different_triangles(
        expected.receivers.as_ref(),
        other.receivers.as_ref(),
        expected.mask.len(),
    );
    let agreement = |doubts: &[Doubt]| {
        Agreement::measure(
            expected.size,
            &expected.mask,
            &other.mask,
            doubts,
            tolerance,
        )
    };
    let mut agreed = agreement(&doubts)?;
    let most_changes = most_changes(recipe);
    let mut changes = vec![0.0_f32; expected.mask.len()];
    for nudge in nudges(recipe, snapping) {
        if agreed.holds() {
            break;
        }
        let nudged = nudge.render(&mut cpu, view, recipe, expected)?;
        for (i, doubt) in doubts.iter_mut().enumerate() {
            let answer = expected.mask[i];
            changes[i] = changes[i].max((nudged.mask[i] - answer).abs());
            let is_excused = changes[i] > 0.0 && {
                let excused = most_changes * changes[i] + AGREEMENT_TOLERANCE + tolerance;
                (other.mask[i] - answer).abs() <= excused
            };
            if is_excused && *doubt == Doubt::None {
                *doubt = Doubt::Rounding;
            }
        }
        agreed = agreement(&doubts)?;
    }
    let plain = Agreement::measure(of_cpu.size, &of_cpu.mask, &other.mask, &doubts, tolerance)?;
    let moved = |(a, b): (&f32, &f32)| (a - b).abs() > AGREEMENT_TOLERANCE + tolerance;
    let by_grid = of_cpu
        .mask
        .iter()
        .zip(&expected.mask)
        .filter(|&pair| moved(pair))
        .count() as u64;
    Ok(Agreement {
        differing: plain.differing,
        largest: plain.largest,
        by_grid,
        ..agreed
    })
}

/// How the CPU rounds if it isn't told otherwise.
fn cpu_rule() -> Snapping {
    Snapping::default()
}

fn different_triangles(a: Option<&Receivers>, b: Option<&Receivers>, len: usize) -> Vec<Doubt> {
    let (Some(a), Some(b)) = (a, b) else {
        return vec![Doubt::None; len];
    };
    if a.len() != len || b.len() != len {
        return vec![Doubt::None; len];
    }
    (0..len)
        .map(|i| {
            if a.triangle[i] == b.triangle[i] {
                Doubt::None
            } else {
                Doubt::Triangle
            }
        })
        .collect()
}
