//! Where things fall on a map that has no size yet.
//!
//! **Map space**: x and y are metres in the light's view, or with perspective tangents (metres across over metres along);
//! z, the *rank*, grows away from the light: metres along the view, or with perspective minus one over them. Triangles
//! stay triangles, and clip depth is linear in the rank, with perspective as without.

use crate::{Aabb, light_space::fit::polygon::Polygon};
use glam::{DAffine3, DVec2, DVec3, Vec3};

/// The way from the world to a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapSpace {
    pub(super) view_from_world: DAffine3,
    /// With perspective, what is nearer than this (metres along the view) is not looked at; none without.
    pub(super) nearest: Option<f64>,
}

/// A box in map space; empty where a `min` is greater than its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    pub(super) fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
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

    /// Whether both share a place on the map, whatever their ranks.
    pub(super) fn meets(&self, other: &Self) -> bool {
        let before = |a: DVec3, b: DVec3| a.truncate().cmple(b.truncate()).all();
        before(self.min, other.max) && before(other.min, self.max)
    }

    /// The same with all ranks, and `by` more to each side.
    pub(super) fn column(&self, by: DVec2) -> Self {
        Self {
            min: (self.min.truncate() - by).extend(f64::NEG_INFINITY),
            max: (self.max.truncate() + by).extend(f64::INFINITY),
        }
    }

    /// What is left of this beside the other: the common part sideways, this one's ranks.
    pub(super) fn within(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min.with_z(self.min.z)),
            max: self.max.min(other.max.with_z(self.max.z)),
        }
    }
}

impl MapSpace {
    /// Returns the map space of a light space that is fitted already.
    #[cfg(feature = "testing")]
    pub(super) fn of(space: &crate::LightSpace) -> Self {
        let projection = space.clip_from_view;
        let perspective = projection.row(3) != glam::Vec4::W;
        let near = f64::from(projection.w_axis.z) / f64::from(projection.z_axis.z);
        Self {
            view_from_world: DAffine3::from_mat4(space.view_from_world.as_dmat4()),
            nearest: perspective.then_some(near.abs()),
        }
    }

    /// A distance along the view as a rank.
    pub(super) fn rank(&self, distance: f64) -> f64 {
        if self.nearest.is_some() {
            -1.0 / distance
        } else {
            distance
        }
    }

    /// A rank as a distance along the view.
    pub(super) fn distance(&self, rank: f64) -> f64 {
        if self.nearest.is_some() {
            -1.0 / rank
        } else {
            rank
        }
    }

    /// A point of the light's view; with perspective it must lie before the light.
    fn project(&self, p: DVec3) -> DVec3 {
        if self.nearest.is_some() {
            DVec3::new(p.x / -p.z, p.y / -p.z, 1.0 / p.z)
        } else {
            p.with_z(-p.z)
        }
    }

    /// A point of the world; none if it falls beside the column, is too near, or behind.
    #[inline]
    pub(super) fn point_within(&self, p: Vec3, column: &Bounds) -> Option<DVec3> {
        let p = self.view_from_world.transform_point3(p.as_dvec3());
        // Asked without dividing: most points fall beside most of a cube's faces.
        let (near, along) = self
            .nearest
            .map_or((true, 1.0), |nearest| (-p.z >= nearest, -p.z));
        let within = |v: f64, min: f64, max: f64| v >= min * along && v <= max * along;
        let inside = near
            && within(p.x, column.min.x, column.max.x)
            && within(p.y, column.min.y, column.max.y);
        inside.then(|| self.project(p))
    }

    /// A triangle of the world, or what of it is far enough.
    pub(super) fn triangle(&self, corners: [Vec3; 3]) -> Polygon {
        let in_view =
            Polygon::triangle(corners.map(|p| self.view_from_world.transform_point3(p.as_dvec3())));
        let polygon = match self.nearest {
            Some(nearest) if in_view.corners().iter().any(|p| -p.z < nearest) => {
                in_view.clip(DVec3::NEG_Z, nearest)
            }
            _ => in_view,
        };
        polygon.map(|p| self.project(p))
    }

    /// A box around all that a box of the world holds; empty when that is too near or behind.
    pub(super) fn block(&self, b: &Aabb) -> Bounds {
        if b.is_empty() {
            return Bounds::EMPTY;
        }
        let (center, half) = (
            (b.min.as_dvec3() + b.max.as_dvec3()) * 0.5,
            (b.max.as_dvec3() - b.min.as_dvec3()) * 0.5,
        );
        let m = self.view_from_world.matrix3;
        let half = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
        let center = self.view_from_world.transform_point3(center);
        let (min, max) = (center - half, center + half);
        let Some(nearest) = self.nearest else {
            return Bounds {
                min: min.with_z(-max.z),
                max: max.with_z(-min.z),
            };
        };
        let (near, far) = ((-max.z).max(nearest), -min.z);
        if far < nearest {
            return Bounds::EMPTY;
        }
        // A negative coordinate is farthest out where it is nearest.
        let least = |v: f64| if v < 0.0 { v / near } else { v / far };
        let most = |v: f64| if v < 0.0 { v / far } else { v / near };
        Bounds {
            min: DVec3::new(least(min.x), least(min.y), -1.0 / near),
            max: DVec3::new(most(max.x), most(max.y), -1.0 / far),
        }
    }
}
