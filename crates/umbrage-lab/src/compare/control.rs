//! The negative control: a comparison that doesn't notice missing casters notices nothing.
//!
//! Each technique is played on the same triangles, none of which casts. What its mask then owes is known, pixel by pixel:
//!
//! * Rays ask the light's points one by one, and see those above the receiver's tangent plane. Truth takes the same points
//!   of the same sequence ([`light_sample`]), so the share that is right is counted, not estimated: there is no noise in
//!   it.
//! * Kernels that know the receiver's horizon
//!   ([`ReceiveKernel::knows_horizon`](umbrage_core::ReceiveKernel::knows_horizon)) owe the share of the light above it, for
//!   which there are formulas ([`horizon`](super::horizon)).
//! * All others take the light for its middle. Where that is above the tangent plane they owe 1. Where it isn't, both 0
//!   (those that look which way a surface faces) and 1 (maps, which don't) are right.
//!
//! Whether a point that lies within rounding of the tangent plane is above it hangs on how far a ray's origin is lifted and
//! on the order of additions: there either answer is right.

use super::{Control, horizon, scene::View3};
use crate::LabError;
use glam::{DVec3, UVec2, Vec2, Vec3};
use rayon::prelude::*;
use umbrage_core::{
    Aabb, Backend, CastMode, Cull, Light, Recipe, RecipeError, ShadowTechnique, Shadows, View,
    light_sample::{LIFT, LightSampler, kind, seed, segment, unit_square},
    metrics::{AGREEMENT_TOLERANCE, ERROR_THRESHOLD, Pixel, near},
};
use umbrage_plan::{footprint, truth::Truth};

/// Plays a technique on the same triangles, none of which casts, and looks at what becomes of its mask. `recipe` and
/// `with_casters` are what it planned and showed with them. None where it can't be planned without casters.
pub(super) fn run(
    backend: &mut dyn Backend,
    technique: &dyn ShadowTechnique,
    view: &View3<'_>,
    truth: &Truth,
    (recipe, with_casters): (&Recipe, &Shadows),
) -> Result<Option<Control>, LabError> {
    let bare = view.geometry.without_casters();
    let bare_view = View3 {
        geometry: &bare,
        ..*view
    };
    // Truth's receivers, so that a backend that sees a neighbouring triangle somewhere isn't judged by another's plane.
    let seen = bare_view.core().with_receivers(&truth.receivers);
    let bare_recipe = match technique.recipe(&seen) {
        Ok(recipe) => recipe,
        Err(RecipeError::Unsupported(_)) => return Ok(None),
        Err(e) => return Err(e.into()),
    };
    let without = backend.render(&seen, &bare_recipe)?;
    let owed = owed(&bare_view, truth, &bare_recipe);
    let tolerance = AGREEMENT_TOLERANCE + bare_recipe.receive.kernel.tolerance();
    let counted = |i: &usize| truth.pixels[*i] == Pixel::Counted;
    let wrong = |i: &usize| {
        let [least, most] = owed[*i];
        !(least - tolerance..=most + tolerance).contains(&without.mask[*i])
    };
    let wrong_without = (0..owed.len()).filter(counted).filter(wrong).count() as u64;
    let looks = !(recipe.casts.is_empty() && recipe.tables.is_empty());
    // Of a light that is hidden whole, the middle and every sample are hidden, too.
    let hidden = |i: usize| {
        looks && counted(&i) && truth.visibility[i] == 0.0 && owed[i][0] > ERROR_THRESHOLD
    };
    let shadow: Vec<bool> = (0..owed.len()).map(hidden).collect();
    let brightened =
        |i: usize| shadow[i] && without.mask[i] - with_casters.mask[i] > ERROR_THRESHOLD;
    let changed = (0..owed.len()).filter(|&i| brightened(i)).count() as u64;
    let shadowed = shadow.iter().filter(|s| **s).count() as u64;
    let blind = shadowed > 0 && changed == 0;
    let excused = blind && may_miss(technique, &view.core(), recipe, truth, &shadow);
    let holds = wrong_without == 0 && (!blind || excused);
    let (backend, technique) = (backend.kind().to_owned(), technique.name().to_owned());
    Ok(Some(Control {
        backend,
        technique,
        shadowed,
        changed,
        wrong_without,
        holds,
    }))
}

/// For every pixel the least and the greatest visibility that is right when nothing casts.
fn owed(view: &View3<'_>, truth: &Truth, recipe: &Recipe) -> Vec<[f32; 2]> {
    let (kernel, receivers) = (&recipe.receive.kernel, &truth.receivers);
    let question = Question::new(
        view,
        kernel.cost_per_receiver().rays,
        kernel.knows_horizon(),
    );
    let at = |i: usize| {
        let pixel = UVec2::new(i as u32 % truth.size.x, i as u32 / truth.size.x);
        if receivers.receives[i] {
            question.owed(receivers.position(i), receivers.normal(i), pixel)
        } else {
            [1.0, 1.0]
        }
    };
    (0..receivers.len()).into_par_iter().map(at).collect()
}

/// What of the light a kernel asks for.
enum Asked {
    Middle,
    /// So many points.
    Points(u32),
    /// The share above the horizon.
    Share,
}

/// How much of a light receivers see over their own horizon.
struct Question {
    light: LightSampler,
    asked: Asked,
    /// The light's middle; none for directions.
    middle: Option<Vec3>,
    /// The unit direction to a directional light.
    direction: Vec3,
    /// How far rays' origins may be lifted off their surface, metres.
    lift: f32,
}

impl Question {
    fn new(view: &View3<'_>, rays: u32, knows_horizon: bool) -> Self {
        let all = view
            .geometry
            .bounds()
            .union(&Aabb::around([view.camera.eye()]));
        let light = LightSampler::new(view.light);
        // One ray serves an ideal light, whatever was asked for.
        let asked = match rays {
            0 if knows_horizon => Asked::Share,
            0 => Asked::Middle,
            _ if light.is_ideal() => Asked::Points(1),
            _ => Asked::Points(rays),
        };
        let middle = view.light.position();
        let direction = if middle.is_none() {
            view.light.direction_from(Vec3::ZERO)
        } else {
            Vec3::ZERO
        };
        let reach = all
            .min
            .abs()
            .max(all.max.abs())
            .max_element()
            .max(extent(view.light));
        Self {
            light,
            asked,
            middle,
            direction,
            lift: reach * LIFT,
        }
    }

    fn owed(&self, p: Vec3, n: Vec3, pixel: UVec2) -> [f32; 2] {
        let to_middle = self.middle.map_or(self.direction, |middle| middle - p);
        match self.asked {
            Asked::Middle => {
                let [surely, _] = self.above(n, to_middle);
                [f32::from(u8::from(surely)), 1.0]
            }
            Asked::Points(count) => {
                let scramble = seed(pixel.x, pixel.y);
                let seen = (0..count).map(|i| self.sees(p, n, unit_square(i, scramble)));
                let [least, most] = seen.fold([0_u32; 2], |sum, sees| {
                    [sum[0] + u32::from(sees[0]), sum[1] + u32::from(sees[1])]
                });
                [least, most].map(|seen| seen as f32 / count as f32)
            }
            Asked::Share => {
                horizon::share(&self.light, p, n, self.margin(to_middle)).map(|share| share as f32)
            }
        }
    }

    /// Whether a point of the light is surely, and whether it may be, above the tangent plane: seen from the surface itself
    /// and from as far above it as rays may start. (A ball's disc turns with the receiver, and its axes jump where they
    /// change their sign: so both ends are asked.)
    fn sees(&self, p: Vec3, n: Vec3, uv: Vec2) -> [bool; 2] {
        let [a, b] =
            [0.0, self.lift].map(|lift| self.above(n, segment(&self.light, p + n * lift, uv, 1.0)));
        [a[0] && b[0], a[1] || b[1]]
    }

    /// The same of a way to the light.
    fn above(&self, n: Vec3, to_light: Vec3) -> [bool; 2] {
        let height = n.as_dvec3().dot(to_light.as_dvec3());
        let margin = self.margin(to_light);
        [height > margin, height > -margin]
    }

    /// By how much the height of a way's end over the surface is wrong: by a lift, which positions' rounding is a part of, and by
    /// the rounding of a sum of three products, 2^-22 of the way's length.
    fn margin(&self, to_light: Vec3) -> f64 {
        let lift = if self.middle.is_some() {
            f64::from(self.lift)
        } else {
            0.0
        };
        lift + DVec3::length(to_light.as_dvec3()) / f64::from(1 << 22)
    }
}

/// The greatest coordinate of a light's points, metres; 0 for directions.
fn extent(light: &Light) -> f32 {
    let sampler = LightSampler::new(light);
    if matches!(sampler.shape.x, kind::DIRECTION | kind::CAP) {
        return 0.0;
    }
    let across =
        sampler.half_u.truncate().abs() + sampler.half_v.truncate().abs() + sampler.half_u.w;
    (sampler.center.truncate().abs() + across).max_element()
}

/// Whether a technique may rightly show nothing of a shadow: what it looks up need not hold it.
///
/// Far sides of casters, which [`Cull::Front`] and peeling keep, are missing where casters are open. And a map's texels may
/// be wider than all of the shadow: one that is darker than its surroundings must cover a texel and all that the kernel
/// averages with it.
fn may_miss(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    recipe: &Recipe,
    truth: &Truth,
    shadow: &[bool],
) -> bool {
    let far_side = recipe
        .casts
        .iter()
        .any(|c| c.cull != Cull::None || matches!(c.mode, CastMode::DepthPeel(_)));
    let Some(reach) = technique.kernel_reach() else {
        return far_side;
    };
    let mut asked = truth.receivers.clone();
    asked.receives.copy_from_slice(shadow);
    let used = footprint::measure(&view.with_receivers(&asked), recipe, &asked, reach).total;
    let Some(texels_per_pixel) = used.texels else {
        return true;
    };
    // Half a texel to the middle of the one looked up, half a texel more to what covers that middle.
    let texels = reach + 1.0;
    let radius = (texels / texels_per_pixel.max(f32::MIN_POSITIVE)).ceil();
    if radius >= truth.size.max_element() as f32 {
        return true;
    }
    let outside: Vec<bool> = shadow.iter().map(|shadow| !shadow).collect();
    let beside = near(truth.size, &outside, radius as u32);
    far_side || beside.iter().all(|&beside| beside)
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
