//! Detection of a model's own ground, and a floor for models without ground.

use super::twice_area;
use crate::primitives::quad;
use umbrage_core::glam::Vec3;
use umbrage_core::{Aabb, Geometry, Mesh};

/// The bottom of a model, as a fraction of its height.
const BOTTOM: f32 = 0.12;
/// A model has its own ground if upward surfaces at its bottom cover this fraction of its bounding
/// rectangle, seen from above. (Floors of rooms do; the bottoms of solids face down.) It also does
/// if its whole surface faces up by as much on balance, like a landscape.
const COVERS: f64 = 0.5;
/// Greatest height of ground without objects over its mean height, as a fraction of the model's
/// height.
const FLAT: f32 = 0.02;
/// Objects on ground are small if they extend over less than this fraction of its length and width.
const SMALL: f32 = 0.5;
/// Half the floor's side over the model's greatest extent. Its edge is far behind the model.
const HALF_SIDE: f32 = 12.0;
/// Distance of the floor below a flat bottom, over the model's greatest extent, so that no two
/// faces share a plane.
const BELOW: f32 = 1e-3;

/// The ground below a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ground {
    /// The mean height of its own ground. `None` without ground.
    pub(super) own: Option<f32>,
    /// `true` if its bottom is flat, which puts the floor slightly lower.
    has_flat_bottom: bool,
}

impl Ground {
    /// Detects the ground of a model.
    pub(super) fn of_geometry(geometry: &Geometry) -> Self {
        let bounds = geometry.bounds();
        let extent = bounds.extent();
        // Measure the footprint from above. Models without one, such as a wall, have no ground.
        let footprint = f64::from(extent.x) * f64::from(extent.z);
        let bottom = bounds.min.y + BOTTOM * extent.y;
        let flat = bounds.min.y + BELOW * extent.max_element();
        let mut facing_up = 0.0;
        let mut heights = 0.0;
        let mut touching = 0.0;
        let mut on_balance = 0.0;
        let mut balanced_heights = 0.0;
        for t in 0..geometry.triangles().len() as u32 {
            let corners = geometry.corners(t);
            let seen_from_above = 0.5 * f64::from(twice_area(corners).y);
            let height = f64::from((corners[0].y + corners[1].y + corners[2].y) / 3.0);
            on_balance += seen_from_above;
            balanced_heights += seen_from_above * height;
            let top = corners[0].y.max(corners[1].y).max(corners[2].y);
            if top <= flat {
                touching += seen_from_above.abs();
            }
            if top <= bottom && seen_from_above > 0.0 {
                facing_up += seen_from_above;
                heights += seen_from_above * height;
            }
        }
        let has_floor = footprint > 0.0 && facing_up >= COVERS * footprint;
        let is_landscape = footprint > 0.0 && on_balance >= COVERS * footprint;
        let own = if has_floor {
            Some((heights / facing_up) as f32)
        } else if is_landscape {
            // The tops and bottoms of solids on it nearly cancel out.
            let mean = (balanced_heights / on_balance) as f32;
            Some(mean.clamp(bounds.min.y, bounds.max.y))
        } else {
            None
        };
        Self {
            own,
            has_flat_bottom: touching > 0.0,
        }
    }

    /// Returns the points of small objects on wide ground of the model's own: the corners of their
    /// triangles, none below the ground. Empty if the objects cover the ground, or without any.
    pub(super) fn objects_on_it(&self, geometry: &Geometry) -> Vec<Vec3> {
        let Some(height) = self.own else {
            return Vec::new();
        };
        let extent = geometry.bounds().extent();
        let above = height + FLAT * extent.y;
        let triangles = (0..geometry.triangles().len() as u32).map(|t| geometry.corners(t));
        let points: Vec<_> = triangles
            .filter(|corners| corners.iter().any(|p| p.y > above))
            .flatten()
            .map(|p| p.with_y(p.y.max(height)))
            .collect();
        let objects = Aabb::from_points(points.iter().copied()).extent();
        let is_small = objects.x < SMALL * extent.x && objects.z < SMALL * extent.z;
        if is_small { points } else { Vec::new() }
    }

    /// Returns the height of the floor for a model with these bounds. `None` if it has its own
    /// ground.
    pub(super) fn floor_height(&self, bounds: Aabb) -> Option<f32> {
        if self.own.is_some() {
            return None;
        }
        let below = if self.has_flat_bottom {
            BELOW * bounds.extent().max_element()
        } else {
            0.0
        };
        Some(bounds.min.y - below)
    }

    /// Returns the floor: a square that faces up.
    pub(super) fn floor(&self, bounds: Aabb) -> Option<Mesh> {
        let height = self.floor_height(bounds)?;
        let half = HALF_SIDE * bounds.extent().max_element();
        let middle = bounds.center();
        let corner = |x: f32, z: f32| Vec3::new(middle.x + x * half, height, middle.z + z * half);
        let corners = [
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
            corner(-1.0, -1.0),
        ];
        Some(Mesh {
            name: "floor".to_owned(),
            ..quad(corners)
        })
    }
}
