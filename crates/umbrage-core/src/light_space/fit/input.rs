//! The input of a fit: a view, with values that several steps share.

use crate::{
    gbuffer::seen_points::SeenPoints,
    geometry::aabb::Aabb,
    light_space::fit::{memory::Cone, points::caster_points},
    parallel::prelude::*,
    view::View,
};
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// Padding around the outermost caster, radians, for rounding.
pub(super) const ANGLE_PADDING: f32 = 1e-3;

/// A valid view, with its visible points and cached results.
#[derive(Clone, Debug)]
pub(super) struct FitInput<'a> {
    pub(super) view: View<'a>,
    /// The points of the view's receivers.
    pub(super) seen: Option<SeenPoints<'a>>,
    caster_cone: OnceLock<Cone>,
}

impl<'a> FitInput<'a> {
    /// Returns the input for a valid view.
    pub(super) fn new(view: View<'a>) -> Self {
        let seen = view.receivers.map(|receivers| match view.fits {
            Some(memory) => memory.seen_points(receivers),
            None => SeenPoints::new(receivers),
        });
        Self {
            view,
            seen,
            caster_cone: OnceLock::new(),
        }
    }

    /// Returns the same input with other visible points.
    pub(super) fn with_seen(&self, seen: SeenPoints<'a>) -> Self {
        Self {
            seen: Some(seen),
            ..self.clone()
        }
    }

    /// Returns the cone from the light at `eye` that contains all casters.
    pub(super) fn cone_around_casters(&self, eye: Vec3) -> Cone {
        let found = match self.view.fits {
            Some(memory) => memory.caster_cone(),
            None => &self.caster_cone,
        };
        *found.get_or_init(|| self.find_cone_around_casters(eye))
    }

    fn find_cone_around_casters(&self, eye: Vec3) -> Cone {
        if self.view.casters.is_empty() {
            return Cone {
                axis: Vec3::NEG_Y,
                half_angle: 0.5,
            };
        }
        let casters = caster_points(self);
        let sum = self.sum_of_directions(eye);
        // If the directions cancel out, use the centre of the casters' box as the axis.
        let axis = if sum.length() > 1e-9 {
            sum.normalize()
        } else {
            let center = casters.bounds().center() - eye;
            center.as_dvec3().normalize_or(-DVec3::Y)
        };
        let least_cosine = casters
            .least(
                |b| least_cosine(b, eye, axis),
                |p| direction(eye, p).dot(axis),
            )
            .min(1.0);
        let half_angle = least_cosine.clamp(-1.0, 1.0).acos() as f32 + ANGLE_PADDING;
        Cone {
            axis: axis.as_vec3(),
            half_angle,
        }
    }

    /// Returns the sum of the unit directions from `eye` to the corners of all casters.
    fn sum_of_directions(&self, eye: Vec3) -> DVec3 {
        let Some(geometry) = self.view.geometry else {
            let corners = self.view.casters.corners();
            return corners.map(|p| direction(eye, p)).sum();
        };
        // Compute directions in parallel: each vertex is used by about six triangles, and its
        // direction costs more than the sum. Add in a fixed order: in symmetric scenes the sum is
        // only what rounding leaves.
        let positions = geometry.positions().par_iter();
        let directions: Vec<DVec3> = positions.map(|&p| direction(eye, p)).collect();
        geometry.box_tree().count(&geometry.casters());
        let corners = geometry.run(&geometry.casters()).iter().flatten();
        corners.map(|&vertex| directions[vertex as usize]).sum()
    }
}

/// Returns the unit direction from `eye` to a point; zero at `eye` itself.
fn direction(eye: Vec3, p: Vec3) -> DVec3 {
    (p - eye).as_dvec3().normalize_or_zero()
}

/// Returns a lower bound of the cosine of the angle, at `eye`, between a unit axis and a point in a
/// box.
fn least_cosine(b: &Aabb, eye: Vec3, axis: DVec3) -> f64 {
    // More than the rounding of directions from 32-bit differences.
    const ROUNDING: f64 = 1e-6;
    let half_diagonal = (b.max.as_dvec3() - b.min.as_dvec3()).length() * 0.5;
    let to_center = (b.min.as_dvec3() + b.max.as_dvec3()) * 0.5 - eye.as_dvec3();
    let distance = to_center.length();
    if distance <= half_diagonal {
        return -1.0;
    }
    let angle_to_center = (to_center.dot(axis) / distance).clamp(-1.0, 1.0).acos();
    let angle_to_rim = (half_diagonal / distance).asin();
    let widest_angle = (angle_to_center + angle_to_rim).min(std::f64::consts::PI);
    widest_angle.cos() - ROUNDING
}
