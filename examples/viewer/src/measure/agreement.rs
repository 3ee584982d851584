//! Comparison of the device's mask with the CPU's for the same recipe and the same receivers.
//!
//! Rasterisers round vertices in different ways, which browsers don't report. Known ways are
//! tested, and the best fit is reported. A pixel is undecided if the CPU's own result changes when
//! maps or receivers move by the possible rounding error.

use super::subject::Subject;
use anyhow::{Context as _, Result};
use umbrage::{
    Backend as _, DepthPlanes, Receivers, Recipe, ShadowTechnique, Snapping, View,
    cpu::{Cpu, CpuOptions, PlaneShift},
    glam::Vec2,
    metrics::{Agreement, Doubt},
    techniques::sampler_tolerance,
};

/// Movement of maps in depth, in the range 0 to 1: 2^-20.
const DEPTH_STEP: f32 = 1.0 / 1_048_576.0;
/// Movement of receivers, as a fraction of their greatest coordinate: 2^-21.
const POSITION_STEP: f32 = 1.0 / 2_097_152.0;

/// A movement by the possible rounding error.
#[derive(Clone, Copy)]
enum Movement {
    /// Receivers move along their normals, by this fraction of their greatest coordinate.
    Receivers(f32),
    /// Maps move sideways, by fractions of half a step of the rasteriser's grid, and in depth.
    Maps([f32; 3]),
    /// The planes of triangles with even and odd numbers move in depth, by fractions of their
    /// rounding error.
    Planes(f32, f32),
}

const MOVEMENTS: [Movement; 12] = {
    use Movement::{Maps, Planes, Receivers};
    [
        Receivers(POSITION_STEP),
        Receivers(-POSITION_STEP),
        Maps([1.0, 1.0, 0.0]),
        Maps([-1.0, 1.0, 0.0]),
        Maps([1.0, -1.0, 0.0]),
        Maps([-1.0, -1.0, 0.0]),
        Maps([0.0, 0.0, DEPTH_STEP]),
        Maps([0.0, 0.0, -DEPTH_STEP]),
        Planes(1.0, 1.0),
        Planes(-1.0, -1.0),
        Planes(1.0, -1.0),
        Planes(-1.0, 1.0),
    ]
};

impl Movement {
    /// Returns the CPU's mask of a moved view and recipe.
    fn mask(
        self,
        view: &View<'_>,
        receivers: &Receivers,
        recipe: &Recipe,
        options: &CpuOptions,
    ) -> Result<Vec<f32>> {
        let mut cpu = Cpu::with_options(options)?;
        let view = view.with_receivers(receivers);
        let shadows = match self {
            Self::Receivers(part) => {
                let moved = moved_receivers(receivers, part);
                cpu.render(&view.with_receivers(&moved), recipe)?
            }
            Self::Maps([x, y, depth]) => {
                let half = 0.5 * options.snapping.step();
                let mut moved = recipe.clone();
                for cast in &mut moved.casts {
                    let size = recipe.images[cast.image].size;
                    cast.space = cast.space.nudge_by(half * Vec2::new(x, y), depth, size);
                }
                cpu.render(&view, &moved)?
            }
            Self::Planes(even, odd) => {
                let shifted = options.plane_shift(PlaneShift { even, odd });
                Cpu::with_options(&shifted)?.render(&view, recipe)?
            }
        };
        Ok(shadows.mask)
    }
}

fn moved_receivers(receivers: &Receivers, part: f32) -> Receivers {
    let mut out = receivers.clone();
    for i in 0..out.len() {
        let position = out.position(i);
        let moved = position + out.normal(i) * (position.abs().max_element() * part);
        (out.x[i], out.y[i], out.z[i]) = (moved.x, moved.y, moved.z);
    }
    out
}

/// Known ways of rounding, the usual one first: the finest grid of hardware, and two of software
/// drivers.
fn roundings() -> [Snapping; 3] {
    let usual = Snapping::default();
    let over_grid = Snapping {
        planes: DepthPlanes::Snapped,
        offset_unit: Snapping::COARSEST.offset_unit,
        ..usual
    };
    [usual, Snapping::COARSEST, over_grid]
}

/// Returns the agreement of a device's mask with the CPU's under the rounding that fits best.
///
/// # Errors
/// Returns an error if there is no mask yet, or the technique refuses the light.
pub(crate) fn agree(
    subject: &Subject,
    receivers: &Receivers,
    technique: &dyn ShadowTechnique,
    mask: Option<&[f32]>,
) -> Result<(Snapping, Agreement)> {
    let mask = mask.context("the device's mask is not yet available")?;
    let view = subject.view();
    let recipe = technique.recipe(&view)?;
    let mut best: Option<(Snapping, Agreement)> = None;
    for snapping in roundings() {
        let agreement = compare(&view, receivers, &recipe, mask, snapping)?;
        let key = |a: &Agreement| (a.violations, a.differing);
        let is_equal = agreement.differing == 0;
        if best
            .as_ref()
            .is_none_or(|(_, best)| key(&agreement) < key(best))
        {
            best = Some((snapping, agreement));
        }
        if is_equal {
            break;
        }
    }
    best.context("no rounding was tried")
}

fn compare(
    view: &View<'_>,
    receivers: &Receivers,
    recipe: &Recipe,
    mask: &[f32],
    snapping: Snapping,
) -> Result<Agreement> {
    let options = CpuOptions::default().snapping(snapping);
    let expected = Cpu::with_options(&options)?.render(&view.with_receivers(receivers), recipe)?;
    let tolerance = sampler_tolerance(&*recipe.receive.kernel);
    let mut doubts = vec![Doubt::None; mask.len()];
    let measure = |doubts: &[Doubt]| {
        Agreement::measure(expected.size, &expected.mask, mask, doubts, tolerance)
    };
    let mut agreement = measure(&doubts)?;
    for movement in MOVEMENTS {
        if agreement.violations == 0 {
            break;
        }
        if recipe.casts.is_empty() && !matches!(movement, Movement::Receivers(_)) {
            break;
        }
        let moved = movement.mask(view, receivers, recipe, &options)?;
        for (doubt, (a, b)) in doubts.iter_mut().zip(expected.mask.iter().zip(&moved)) {
            if a != b {
                *doubt = Doubt::Rounding;
            }
        }
        agreement = measure(&doubts)?;
    }
    Ok(agreement)
}
