//! Positions on a map whose size is not yet known.
//!
//! **Map space**: x and y are metres in the light's view; with perspective, they are tangents
//! (metres across over metres along). z is the *rank*, which grows away from the light. It is
//! metres along the view; with perspective, minus one over them. Triangles stay triangles, and clip
//! depth is linear in the rank, with perspective or without.

use crate::{
    geometry::{
        aabb::Aabb,
        clip_polygon::{Polygon, edge_crossing},
    },
    light_space::view_box::ViewBox,
};
use glam::{DAffine3, DVec2, DVec3, Vec3};

/// A polygon in view or map space. Triangles are clipped by the near plane and by the four sides of
/// a map, so they have at most eight corners.
pub(super) type MapPolygon = Polygon<DVec3, 8>;

/// Returns the part of a polygon where `normal . p >= distance`.
pub(super) fn clip(polygon: &MapPolygon, normal: DVec3, distance: f64) -> MapPolygon {
    polygon.clip(|p| normal.dot(p) - distance, edge_crossing)
}

/// The transform from world space to map space.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapSpace {
    pub(super) view_from_world: DAffine3,
    /// With perspective, the distance (metres along the view) below which geometry is ignored;
    /// `None` without perspective.
    pub(super) nearest: Option<f64>,
}

/// A box in map space; empty where a `min` is greater than its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MapBounds {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
}

impl MapBounds {
    pub(super) const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    pub(super) fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |b, p| b.union(&Self { min: p, max: p }))
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Returns whether both overlap laterally, for any ranks.
    pub(super) fn meets(&self, other: &Self) -> bool {
        let self_begins = self.min.truncate().cmple(other.max.truncate()).all();
        let other_begins = other.min.truncate().cmple(self.max.truncate()).all();
        self_begins && other_begins
    }

    /// Returns the column of the bounds: all ranks, and grown laterally by `by`.
    pub(super) fn column(&self, by: DVec2) -> Self {
        Self {
            min: (self.min.truncate() - by).extend(f64::NEG_INFINITY),
            max: (self.max.truncate() + by).extend(f64::INFINITY),
        }
    }

    /// Intersects the lateral bounds with `other`; keeps the range of ranks.
    pub(super) fn intersection(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min.with_z(self.min.z)),
            max: self.max.min(other.max.with_z(self.max.z)),
        }
    }
}

impl MapSpace {
    /// Returns the map space of a fitted light space.
    #[cfg(feature = "testing")]
    pub(super) fn of_light_space(space: &crate::light_space::LightSpace) -> Self {
        let projection = space.clip_from_view;
        let perspective = projection.row(3) != glam::Vec4::W;
        let near = f64::from(projection.w_axis.z) / f64::from(projection.z_axis.z);
        Self {
            view_from_world: DAffine3::from_mat4(space.view_from_world.as_dmat4()),
            nearest: perspective.then_some(near.abs()),
        }
    }

    /// Converts a distance along the view to a rank.
    pub(super) fn rank(&self, distance: f64) -> f64 {
        if self.nearest.is_some() {
            -1.0 / distance
        } else {
            distance
        }
    }

    /// Converts a rank to a distance along the view.
    pub(super) fn distance(&self, rank: f64) -> f64 {
        if self.nearest.is_some() {
            -1.0 / rank
        } else {
            rank
        }
    }

    /// Projects a point of the light's view; with perspective it must be in front of the light.
    fn project(&self, p: DVec3) -> DVec3 {
        if self.nearest.is_some() {
            DVec3::new(p.x / -p.z, p.y / -p.z, 1.0 / p.z)
        } else {
            p.with_z(-p.z)
        }
    }

    /// Converts a world-space point to map space. `None` if it is outside the column, or with
    /// perspective too near or behind the light.
    #[inline]
    pub(super) fn point_within(&self, p: Vec3, column: &MapBounds) -> Option<DVec3> {
        let p = self.view_from_world.transform_point3(p.as_dvec3());
        if self.nearest.is_some_and(|nearest| -p.z < nearest) {
            return None;
        }
        // Compare `x / along` without dividing: most points are outside most faces of a cube.
        let along = if self.nearest.is_some() { -p.z } else { 1.0 };
        let inside = p.x >= column.min.x * along
            && p.x <= column.max.x * along
            && p.y >= column.min.y * along
            && p.y <= column.max.y * along;
        inside.then(|| self.project(p))
    }

    /// Returns the box around a world-space triangle, as around the corners of
    /// [`MapSpace::triangle`]. `None` with perspective if a part of the triangle is too near.
    pub(super) fn whole_triangle_bounds(&self, corners: &[Vec3; 3]) -> Option<MapBounds> {
        let in_view = corners.map(|p| self.view_from_world.transform_point3(p.as_dvec3()));
        let is_cut = self
            .nearest
            .is_some_and(|nearest| in_view.iter().any(|p| -p.z < nearest));
        (!is_cut).then(|| MapBounds::from_points(in_view.map(|p| self.project(p))))
    }

    /// Converts a world-space triangle to map space; with perspective, the part of it that is not
    /// too near.
    pub(super) fn triangle(&self, corners: [Vec3; 3]) -> MapPolygon {
        let corners_in_view = corners.map(|p| self.view_from_world.transform_point3(p.as_dvec3()));
        let in_view = MapPolygon::triangle(corners_in_view);
        let far_enough = match self.nearest {
            Some(nearest) if corners_in_view.iter().any(|p| -p.z < nearest) => {
                clip(&in_view, DVec3::NEG_Z, nearest)
            }
            _ => in_view,
        };
        far_enough.map(|p| self.project(p))
    }

    /// Returns the box in map space around a world-space box; with perspective, around the part of
    /// it that is not too near. Empty if no part is left.
    pub(super) fn block(&self, b: &Aabb) -> MapBounds {
        if b.is_empty() {
            return MapBounds::EMPTY;
        }
        self.bounds_of(&ViewBox::new(&self.view_from_world, b))
    }

    /// Returns a box in map space around everything in a world-space box, with a margin for
    /// rounding. It contains the results of [`MapSpace::block`], [`MapSpace::triangle`] and
    /// [`MapSpace::point_within`] for all of the box's contents. Empty if there are no results.
    pub(super) fn group(&self, b: &Aabb) -> MapBounds {
        if b.is_empty() {
            return MapBounds::EMPTY;
        }
        self.bounds_of(&ViewBox::padded_box(&self.view_from_world, b))
    }

    /// Returns the box in map space around a box of the view, or around the part of it that is not
    /// too near.
    fn bounds_of(&self, in_view: &ViewBox) -> MapBounds {
        let min = in_view.min();
        let max = in_view.max();
        let Some(nearest) = self.nearest else {
            return MapBounds {
                min: min.with_z(-max.z),
                max: max.with_z(-min.z),
            };
        };
        // Compute distances along the view, which looks along -z.
        let near = (-max.z).max(nearest);
        let far = -min.z;
        if far < nearest {
            return MapBounds::EMPTY;
        }
        MapBounds {
            min: DVec3::new(
                least_tangent(min.x, near, far),
                least_tangent(min.y, near, far),
                -1.0 / near,
            ),
            max: DVec3::new(
                greatest_tangent(max.x, near, far),
                greatest_tangent(max.y, near, far),
                -1.0 / far,
            ),
        }
    }
}

/// Returns the least of `across / distance` over distances from `near` to `far`. For a negative
/// coordinate it is at `near`.
fn least_tangent(across: f64, near: f64, far: f64) -> f64 {
    if across < 0.0 {
        across / near
    } else {
        across / far
    }
}

/// Returns the greatest of `across / distance` over distances from `near` to `far`.
fn greatest_tangent(across: f64, near: f64, far: f64) -> f64 {
    if across < 0.0 {
        across / far
    } else {
        across / near
    }
}
