//! Negative control: renders each technique without casters, to check that the comparison detects
//! their absence.
//!
//! The triangles are the same, but none of them casts. The correct mask is then known for each
//! pixel:
//!
//! * Ray kernels test points of the light and count those above the receiver's tangent plane. Truth
//!   uses the same points of the same sequence ([`light_sample`]), so the correct share is counted
//!   without noise.
//! * Kernels that account for the receiver's horizon ([`CataloguedKernel::horizon_error`]) must
//!   return the share of the light above it, which [`horizon`](super::horizon) computes.
//! * All other kernels treat the light as its centre. If the centre is above the tangent plane,
//!   they must return 1. Otherwise both 0 (kernels that test the surface's orientation) and 1
//!   (maps, which don't) are correct.
//!
//! A point within rounding of the tangent plane may count as above or below it. The result depends
//! on the lift of the ray's origin and on the order of additions.

use super::{horizon, result::Control, seen::SceneView};
use crate::error::LabError;
use glam::{DVec3, UVec2, Vec2, Vec3};
use rayon::prelude::*;
use umbrage_core::{
    Aabb, Backend, CastMode, Cull, Light, Recipe, RecipeError, ShadowTechnique, Shadows, View,
    light_sample::{LIFT, LightSampler, kind, seed, segment, unit_square},
    metrics::{AGREEMENT_TOLERANCE, ERROR_THRESHOLD, Pixel, pixels_near},
};
use umbrage_plan::{
    catalogue::{Catalogue, CataloguedKernel},
    footprint,
    truth::Truth,
};
use umbrage_techniques::{TechniquePreset, sampler_tolerance};

/// Renders a technique on the same triangles without casters, and checks its mask.
///
/// `recipe` and `with_casters` are its recipe and its result with casters. `None` if the technique
/// has no recipe without casters.
pub(super) fn run(
    backend: &mut dyn Backend,
    technique: &TechniquePreset,
    view: &SceneView<'_>,
    truth: &Truth,
    recipe: &Recipe,
    with_casters: &Shadows,
    catalogue: &Catalogue,
) -> Result<Option<Control>, LabError> {
    let bare = view.geometry.without_casters();
    let bare_view = SceneView {
        geometry: &bare,
        ..*view
    };
    // Use truth's receivers: a backend that sees a neighbouring triangle at a pixel must not be
    // judged by another plane.
    let seen = bare_view.core().with_receivers(&truth.receivers);
    let bare_recipe = match technique.recipe(&seen) {
        Ok(recipe) => recipe,
        Err(RecipeError::Unsupported(_)) => return Ok(None),
        Err(e) => return Err(e.into()),
    };
    let without = backend.render(&seen, &bare_recipe)?;
    let kernel = catalogue.kernel(&bare_recipe);
    let expected = expected_without_casters(&bare_view, truth, kernel);
    let tolerance = AGREEMENT_TOLERANCE + sampler_tolerance(&*bare_recipe.receive.kernel);
    let horizon_error = kernel.horizon_error().unwrap_or(0.0);
    let is_counted = |i: usize| truth.pixels[i] == Pixel::Counted;
    let wrong_without = (0..expected.len())
        .filter(|&i| {
            // Counting points has an error only where the horizon crosses the light.
            let error = if expected[i].is_partial() {
                horizon_error
            } else {
                0.0
            };
            is_counted(i) && !expected[i].contains(without.mask[i], tolerance + error)
        })
        .count() as u64;
    // A recipe without casts and caster tables shows no shadow, and need not.
    let knows_casters = !recipe.casts.is_empty() || !recipe.tables.is_empty();
    // If casters hide the whole light, its centre and all its samples are hidden, too.
    let shadow: Vec<bool> = (0..expected.len())
        .map(|i| {
            let is_lit_without = expected[i].min > ERROR_THRESHOLD;
            knows_casters && is_counted(i) && truth.visibility[i] == 0.0 && is_lit_without
        })
        .collect();
    let changed = (0..expected.len())
        .filter(|&i| shadow[i] && without.mask[i] - with_casters.mask[i] > ERROR_THRESHOLD)
        .count() as u64;
    let shadowed = shadow.iter().filter(|s| **s).count() as u64;
    let shows_no_shadow = shadowed > 0 && changed == 0;
    let is_excused =
        shows_no_shadow && may_miss(technique, &view.core(), recipe, truth, &shadow, catalogue);
    let holds = wrong_without == 0 && (!shows_no_shadow || is_excused);
    Ok(Some(Control {
        backend: backend.kind().to_owned(),
        technique: technique.name().to_owned(),
        shadowed,
        changed,
        wrong_without,
        holds,
    }))
}

/// Correct visibilities of a pixel, 0..=1.
#[derive(Clone, Copy, Debug)]
struct VisibilityRange {
    min: f32,
    max: f32,
}

impl VisibilityRange {
    const LIT: Self = Self { min: 1.0, max: 1.0 };

    /// Reports whether the light is partially visible.
    fn is_partial(self) -> bool {
        self.max > 0.0 && self.min < 1.0
    }

    fn contains(self, visibility: f32, tolerance: f32) -> bool {
        (self.min - tolerance..=self.max + tolerance).contains(&visibility)
    }
}

/// Returns the correct visibilities of every pixel without casters.
fn expected_without_casters(
    view: &SceneView<'_>,
    truth: &Truth,
    kernel: &dyn CataloguedKernel,
) -> Vec<VisibilityRange> {
    let receivers = &truth.receivers;
    let horizon = LightOverHorizon::new(
        view,
        kernel.cost_per_receiver().rays,
        kernel.horizon_error().is_some(),
    );
    (0..receivers.len())
        .into_par_iter()
        .map(|i| {
            if !receivers.receives[i] {
                return VisibilityRange::LIT;
            }
            let pixel = UVec2::new(i as u32 % truth.size.x, i as u32 / truth.size.x);
            horizon.expected_visibility(receivers.position(i), receivers.normal(i), pixel)
        })
        .collect()
}

/// The part of the light that a kernel tests.
enum KernelQuery {
    /// The light's centre only.
    Center,
    /// This number of points.
    Points(u32),
    /// The visible share above the horizon.
    Share,
}

/// Position of a point of the light relative to a receiver's tangent plane.
#[derive(Clone, Copy, Debug)]
struct Above {
    /// It is above the plane.
    surely: bool,
    /// It is above the plane or within rounding of it.
    maybe: bool,
}

/// A light as seen by receivers over their own horizon.
struct LightOverHorizon {
    light: LightSampler,
    query: KernelQuery,
    /// The light's centre. `None` for directional lights.
    center: Option<Vec3>,
    /// The unit direction to a directional light.
    direction: Vec3,
    /// Maximum lift of ray origins off their surface, metres.
    lift: f32,
}

impl LightOverHorizon {
    fn new(view: &SceneView<'_>, rays: u32, knows_horizon: bool) -> Self {
        let bounds = view
            .geometry
            .bounds()
            .union(&Aabb::from_points([view.camera.eye()]));
        let light = LightSampler::new(view.light);
        // An ideal light needs one ray, whatever the number of samples.
        let query = match rays {
            _ if knows_horizon && !light.is_ideal() => KernelQuery::Share,
            0 => KernelQuery::Center,
            _ if light.is_ideal() => KernelQuery::Points(1),
            _ => KernelQuery::Points(rays),
        };
        let center = view.light.position();
        let direction = if center.is_none() {
            view.light.direction_from(Vec3::ZERO)
        } else {
            Vec3::ZERO
        };
        let bounds_reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let reach = bounds_reach.max(extent(view.light));
        Self {
            light,
            query,
            center,
            direction,
            lift: reach * LIFT,
        }
    }

    /// Returns the correct visibilities at a position with a unit normal.
    fn expected_visibility(&self, position: Vec3, normal: Vec3, pixel: UVec2) -> VisibilityRange {
        let to_center = self
            .center
            .map_or(self.direction, |center| center - position);
        match self.query {
            KernelQuery::Center => {
                let above = self.side_of_tangent_plane(normal, to_center);
                VisibilityRange {
                    min: f32::from(u8::from(above.surely)),
                    max: 1.0,
                }
            }
            KernelQuery::Points(count) => {
                let scramble = seed(pixel.x, pixel.y);
                let mut surely = 0_u32;
                let mut maybe = 0_u32;
                for i in 0..count {
                    let above = self.sees(position, normal, unit_square(i, scramble));
                    surely += u32::from(above.surely);
                    maybe += u32::from(above.maybe);
                }
                VisibilityRange {
                    min: surely as f32 / count as f32,
                    max: maybe as f32 / count as f32,
                }
            }
            KernelQuery::Share => {
                let margin = self.margin(to_center);
                let [min, max] = horizon::share(&self.light, position, normal, margin);
                VisibilityRange {
                    min: min as f32,
                    max: max as f32,
                }
            }
        }
    }

    /// Reports whether a point of the light is surely, or possibly, above the tangent plane.
    ///
    /// Tests from the surface and from the highest ray origin above it. The disc of a spherical
    /// light turns with the receiver, and its axes jump when their signs change.
    fn sees(&self, position: Vec3, normal: Vec3, uv: Vec2) -> Above {
        let on_surface = segment(&self.light, position + normal * 0.0, uv, 1.0);
        let lifted = segment(&self.light, position + normal * self.lift, uv, 1.0);
        let from_surface = self.side_of_tangent_plane(normal, on_surface);
        let from_lifted = self.side_of_tangent_plane(normal, lifted);
        Above {
            surely: from_surface.surely && from_lifted.surely,
            maybe: from_surface.maybe || from_lifted.maybe,
        }
    }

    /// Reports whether a vector to the light points above the tangent plane.
    fn side_of_tangent_plane(&self, normal: Vec3, to_light: Vec3) -> Above {
        let height = normal.as_dvec3().dot(to_light.as_dvec3());
        let margin = self.margin(to_light);
        Above {
            surely: height > margin,
            maybe: height > -margin,
        }
    }

    /// Returns the error bound of a light point's height over the surface, metres.
    ///
    /// It is the sum of the lift, which includes the rounding of positions, and 2^-22 of the
    /// vector's length, for a sum of three products.
    fn margin(&self, to_light: Vec3) -> f64 {
        let lift = if self.center.is_some() {
            f64::from(self.lift)
        } else {
            0.0
        };
        lift + DVec3::length(to_light.as_dvec3()) / f64::from(1 << 22)
    }
}

/// Returns the greatest coordinate of a light's points, metres. 0 for directional lights.
fn extent(light: &Light) -> f32 {
    let sampler = LightSampler::new(light);
    if matches!(sampler.shape.x, kind::DIRECTION | kind::CAP) {
        return 0.0;
    }
    let across =
        sampler.half_u.truncate().abs() + sampler.half_v.truncate().abs() + sampler.half_u.w;
    (sampler.center.truncate().abs() + across).max_element()
}

/// Reports whether a technique may correctly show nothing of a shadow, because its maps need not
/// contain it.
///
/// [`Cull::Front`] and peeling keep the far sides of casters, which are missing if casters are
/// open. A map's texels may also be wider than the whole shadow. A shadow that is darker than its
/// surroundings must cover a texel and all texels that the kernel averages.
fn may_miss(
    technique: &TechniquePreset,
    view: &View<'_>,
    recipe: &Recipe,
    truth: &Truth,
    shadow: &[bool],
    catalogue: &Catalogue,
) -> bool {
    let far_side = recipe
        .casts
        .iter()
        .any(|c| c.cull != Cull::None || matches!(c.mode, CastMode::DepthPeel(_)));
    let Some(reach) = catalogue.kernel_reach(technique) else {
        return far_side;
    };
    let mut requested = truth.receivers.clone();
    requested.receives.copy_from_slice(shadow);
    let view = view.with_receivers(&requested);
    let kernel = catalogue.kernel(recipe);
    let used = footprint::measure(&view, recipe, &requested, reach, kernel).total;
    let Some(texels_per_pixel) = used.texels else {
        return true;
    };
    // Half a texel to the centre of the looked-up texel, and half a texel more to the edge of what
    // covers it.
    let texels = reach + 1.0;
    let radius = (texels / texels_per_pixel.max(f32::MIN_POSITIVE)).ceil();
    if radius >= truth.size.max_element() as f32 {
        return true;
    }
    let outside: Vec<bool> = shadow.iter().map(|shadow| !shadow).collect();
    let adjacent = pixels_near(truth.size, &outside, radius as u32);
    far_side || adjacent.iter().all(|&adjacent| adjacent)
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
