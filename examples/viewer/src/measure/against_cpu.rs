//! A device's mask against the one that the CPU makes of the same recipe and the same receivers.
//!
//! Rasterisers round vertices each in their own way, and no call of a browser's tells which: known ways are tried, and the one that fits
//! best is reported. A pixel is undecided where the CPU's own answer changes as maps or receivers move by what rounding may come to.

use super::planned_view;
use crate::app::App;
use anyhow::{Context as _, Result};
use umbrage::{
    Aabb, Backend as _, Camera, DepthPlanes, Geometry, Light, Receivers, Recipe, ShadowTechnique,
    Snapping, View,
    cpu::{Cpu, CpuOptions, PlaneShift},
    glam::Vec2,
    metrics::{Agreement, Doubt},
    techniques::sampler_tolerance,
};

/// How far maps move in depth, of 0 to 1: 2^-20.
const DEPTH_STEP: f32 = 1.0 / 1_048_576.0;
/// How far receivers move, as a part of their greatest coordinate: 2^-21.
const PLACE_STEP: f32 = 1.0 / 2_097_152.0;

/// What masks are made of.
pub(crate) struct Compared<'a> {
    camera: Camera,
    pub light: Light,
    geometry: &'a Geometry,
    /// The box around all casters for which the light sets plan.
    casters: Aabb,
    receivers: &'a Receivers,
}

/// How well a mask agrees with the CPU's.
pub(crate) struct Found {
    pub snapping: Snapping,
    pub agreement: Agreement,
}

/// Ways of devices to round, the usual one first: the finest grid on hardware, and software drivers' two.
fn roundings() -> [Snapping; 3] {
    let usual = Snapping::default();
    let over_grid = Snapping {
        planes: DepthPlanes::Snapped,
        offset_unit: Snapping::COARSEST.offset_unit,
        ..usual
    };
    [usual, Snapping::COARSEST, over_grid]
}

impl<'a> Compared<'a> {
    /// Returns what the sides' masks are made of; none if they aren't made.
    pub(crate) fn of_app(app: &'a App) -> Option<Self> {
        Some(Self {
            camera: app.camera?,
            light: app.settings.lights.get(app.settings.chosen)?.light,
            geometry: &app.stage.geometry,
            casters: app.renderer.sides[0].set.casters_box(),
            receivers: &app.figures.truth.as_ref()?.receivers,
        })
    }

    /// Plays a technique on the CPU, and compares its mask with a device's.
    ///
    /// # Errors
    /// Errors if there is no mask, or the technique can't be played.
    pub(crate) fn agree(
        &self,
        technique: &dyn ShadowTechnique,
        mask: Option<&[f32]>,
    ) -> Result<Found> {
        let mask = mask.context("the device's mask isn't there yet")?;
        let view = planned_view(&self.camera, &self.light, self.geometry, self.casters);
        let recipe = technique.recipe(&view)?;
        let seen = view.with_receivers(self.receivers);
        let mut best: Option<Found> = None;
        for snapping in roundings() {
            let agreement = self.compare(&seen, &recipe, mask, snapping)?;
            let is_better = best.as_ref().is_none_or(|best| {
                let key = |a: &Agreement| (a.violations, a.differing);
                key(&agreement) < key(&best.agreement)
            });
            let is_equal = agreement.differing == 0;
            if is_better {
                best = Some(Found {
                    snapping,
                    agreement,
                });
            }
            if is_equal {
                break;
            }
        }
        best.context("no rounding was tried")
    }

    fn compare(
        &self,
        view: &View<'_>,
        recipe: &Recipe,
        mask: &[f32],
        snapping: Snapping,
    ) -> Result<Agreement> {
        let options = CpuOptions::default().snapping(snapping);
        let mut cpu = Cpu::with_options(&options)?;
        let expected = cpu.render(view, recipe)?;
        let tolerance = sampler_tolerance(&*recipe.receive.kernel);
        let mut doubts = vec![Doubt::None; mask.len()];
        let measure = |doubts: &[Doubt]| {
            Agreement::measure(expected.size, &expected.mask, mask, doubts, tolerance)
        };
        let mut agreement = measure(&doubts)?;
        let mut doubt = |moved: &[f32]| -> Result<bool> {
            for (doubt, (a, b)) in doubts.iter_mut().zip(expected.mask.iter().zip(moved)) {
                if a != b {
                    *doubt = Doubt::Rounding;
                }
            }
            agreement = measure(&doubts)?;
            Ok(agreement.violations == 0)
        };
        if expected.mask == mask {
            return Ok(agreement);
        }
        for part in [PLACE_STEP, -PLACE_STEP] {
            let moved = moved(self.receivers, part);
            if doubt(&cpu.render(&view.with_receivers(&moved), recipe)?.mask)? {
                return Ok(agreement);
            }
        }
        if recipe.casts.is_empty() {
            return Ok(agreement);
        }
        let half = 0.5 * snapping.step();
        for (x, y, depth) in [
            (half, half, 0.0),
            (-half, half, 0.0),
            (half, -half, 0.0),
            (-half, -half, 0.0),
            (0.0, 0.0, DEPTH_STEP),
            (0.0, 0.0, -DEPTH_STEP),
        ] {
            let moved = nudged(recipe, Vec2::new(x, y), depth);
            if doubt(&cpu.render(view, &moved)?.mask)? {
                return Ok(agreement);
            }
        }
        for (even, odd) in [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)] {
            let shifted = options.plane_shift(PlaneShift { even, odd });
            let mut cpu = Cpu::with_options(&shifted)?;
            if doubt(&cpu.render(view, recipe)?.mask)? {
                break;
            }
        }
        Ok(agreement)
    }
}

/// Returns a recipe with all its maps moved by texels and depth; lookups stay.
fn nudged(recipe: &Recipe, texels: Vec2, depth: f32) -> Recipe {
    let mut out = recipe.clone();
    for cast in &mut out.casts {
        let size = recipe.images[cast.image].size;
        cast.space = cast.space.nudged(texels, depth, size);
    }
    out
}

/// Returns receivers moved along their normals by a part of their greatest coordinate.
fn moved(receivers: &Receivers, part: f32) -> Receivers {
    let mut out = receivers.clone();
    for i in 0..out.len() {
        let place = out.position(i);
        let to = place + out.normal(i) * (place.abs().max_element() * part);
        (out.x[i], out.y[i], out.z[i]) = (to.x, to.y, to.z);
    }
    out
}
