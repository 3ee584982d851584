//! Agreement of other backends with the CPU.
//!
//! Devices round vertices to grids of 1/16 to 1/256 pixels, and some compute depth planes from the
//! rounded vertices. This alone moves the edges of geometry and shadows. So the CPU executes the
//! recipe a second time with the vertex rounding of the other device ([`Snapping`]), and the other
//! backend must agree with that result. No more pixels are undecided on other grids.

use crate::{compare::nudges::nudges, error::LabError};
use umbrage_core::{
    Backend, Receivers, Recipe, Shadows, Snapping, View,
    metrics::{AGREEMENT_TOLERANCE, Agreement, Doubt},
};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_techniques::sampler_tolerance;

/// Allowed difference of a device, as a multiple of the change of the CPU's result. A device rounds
/// everything at once, and several taps of a filter may change together.
const MOST_CHANGES: f32 = 4.0;

/// Returns the same for a recipe. Filtered images have no bound: 16-bit `msm` with a small bias
/// amplifies other rounding of its quotients 40,000 times.
fn most_changes(recipe: &Recipe) -> f32 {
    if recipe.filters.is_empty() {
        MOST_CHANGES
    } else {
        f32::INFINITY
    }
}

/// Compares a backend's mask with the CPU's mask at the same vertex rounding.
///
/// `of_cpu` is the CPU's result with its own rounding. [`Agreement::differing`] and
/// [`Agreement::largest`] are relative to that.
///
/// Pixels where the two see different triangles are counted separately. Other pixels that differ by
/// more than the tolerance are *undecided* if perturbations within rounding (`nudges.rs`) change
/// the CPU's result by a quarter of the difference. With filtered images, any change suffices. All
/// others are violations. Equal masks need no nudges, so none are rendered.
///
/// # Errors
/// Errors if the CPU can't execute the recipe, or if the masks have different sizes or values
/// outside 0..=1.
pub fn agree(
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    other: &Shadows,
    snapping: Snapping,
) -> Result<Agreement, LabError> {
    let mut cpu = Cpu::with_options(&CpuOptions::default().snapping(snapping))?;
    let executed = if snapping == cpu_rule() {
        None
    } else {
        Some(cpu.render(view, recipe)?)
    };
    let expected = executed.as_ref().unwrap_or(of_cpu);
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

/// Returns the CPU's default rounding.
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
