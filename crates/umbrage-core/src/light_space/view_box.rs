//! World-space boxes transformed to a view, padded for rounding.

use crate::geometry::aabb::Aabb;
use glam::{DAffine3, DVec3};

/// Padding for rounding, as a fraction of the summands: a few sums and products of `f64` have
/// rounding errors of 2^-53 each.
pub(crate) const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// A box in view space around a world-space box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewBox {
    pub(crate) center: DVec3,
    /// Half of the box's sides.
    pub(crate) half: DVec3,
}

impl ViewBox {
    /// Returns the smallest such box, apart from rounding; meaningless for an empty box.
    pub(crate) fn new(view_from_world: &DAffine3, b: &Aabb) -> Self {
        let center = (b.min.as_dvec3() + b.max.as_dvec3()) * 0.5;
        let half = (b.max.as_dvec3() - b.min.as_dvec3()) * 0.5;
        // Compute the half extents in view space: |M| h (Arvo 1990, "Transforming axis-aligned
        // bounding boxes").
        let m = view_from_world.matrix3;
        Self {
            center: view_from_world.transform_point3(center),
            half: m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z,
        }
    }

    /// Returns a box that contains every point or box within the world-space box, as transformed in
    /// `f64` arithmetic. Everything outside this box is therefore outside each of them, bit for
    /// bit.
    pub(crate) fn padded_box(view_from_world: &DAffine3, b: &Aabb) -> Self {
        let smallest = Self::new(view_from_world, b);
        let m = view_from_world.matrix3;
        let reach = b.min.abs().max(b.max.abs()).as_dvec3();
        let summed = m.x_axis.abs() * reach.x
            + m.y_axis.abs() * reach.y
            + m.z_axis.abs() * reach.z
            + view_from_world.translation.abs();
        Self {
            half: smallest.half + DVec3::splat(summed.max_element() * ROUNDING),
            ..smallest
        }
    }

    pub(crate) fn min(&self) -> DVec3 {
        self.center - self.half
    }

    pub(crate) fn max(&self) -> DVec3 {
        self.center + self.half
    }
}
