//! Rays to the sun: 64-bit tests of the casters that the library's hierarchy preselects.

use crate::{Facets, Points, facets::reach_of};
use glam::{DMat3, DVec3, Vec3, Vec3Swizzles as _, Vec4};
use umbrage_core::{
    Aabb,
    bvh::{Shaft, ShaftSearch},
};

/// Mark for no blocker.
pub(crate) const NO_BLOCKER: u32 = u32::MAX;

/// Light of a point from one sun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PointLight {
    pub(crate) is_lit: bool,
    /// True if a shift of coordinates by the margin may change the answer.
    pub(crate) is_undecided: bool,
    /// A facet that certainly shades the point, or [`NO_BLOCKER`].
    pub(crate) blocker: u32,
}

/// Facets prepared for rays from points.
pub(crate) struct Rays<'a> {
    pub(crate) facets: &'a Facets,
    points: &'a Points,
    /// Of the points, if they were made for other facets.
    shift: DVec3,
    /// Metres.
    pub(crate) margin: f64,
    /// Greatest distance between a point and the far end of a facet along an axis, metres.
    length: f64,
    /// Rounding of points and facets to 32 bits, metres.
    rounding: f64,
}

impl<'a> Rays<'a> {
    /// Prepares the facets for rays from points.
    pub(crate) fn new(facets: &'a Facets, points: &'a Points) -> Self {
        let shift = points.anchor - facets.anchor;
        let points_reach = reach_of(&points.positions) + reach_of(&[shift]);
        let reach = points_reach.max(reach_of(&facets.bounds));
        Self {
            facets,
            points,
            shift,
            margin: facets.margin_within(reach),
            // The diagonal of the box of both, in all directions.
            length: 4.0 * reach,
            rounding: 2.0 * f64::from(f32::EPSILON) * reach,
        }
    }

    /// Returns the position of a point relative to the facets' anchor, and its unit normal or zero.
    pub(crate) fn point(&self, row: usize) -> [DVec3; 2] {
        let normal = self.points.normals.get(row);
        [
            self.points.positions[row] + self.shift,
            normal.copied().unwrap_or(DVec3::ZERO),
        ]
    }

    /// Returns whether a point sees the centre of the sun. `guess` is a facet that is tested first,
    /// or [`NO_BLOCKER`].
    #[inline]
    pub(crate) fn answer(&self, row: usize, frame: &DMat3, guess: u32) -> PointLight {
        let [p, normal] = self.point(row);
        let incidence = normal.dot(frame.z_axis);
        if normal != DVec3::ZERO && incidence <= 0.0 {
            return PointLight {
                is_lit: false,
                // Normals have some roundings.
                is_undecided: incidence > -1e-12,
                blocker: NO_BLOCKER,
            };
        }
        let mut search = RaySearch {
            rays: self,
            p,
            frame,
            is_hit: false,
            is_near: normal != DVec3::ZERO && incidence < 1e-12,
            blocker: NO_BLOCKER,
        };
        if guess == NO_BLOCKER || !search.test(guess) {
            self.visit_casters(p, frame.z_axis, 0.0, |id| search.test(id));
        }
        let is_certain = search.blocker != NO_BLOCKER;
        PointLight {
            is_lit: !is_certain && !search.is_hit,
            is_undecided: !is_certain && (search.is_hit || search.is_near),
            blocker: search.blocker,
        }
    }

    /// Passes the facets that may hide a part of a cone around the sun to `visit`, until it returns
    /// true. `slope` is the tangent of the cone's angle.
    fn visit_casters(&self, p: DVec3, sun: DVec3, slope: f64, visit: impl FnMut(u32) -> bool) {
        let start = Aabb {
            min: (p - self.rounding).as_vec3(),
            max: (p + self.rounding).as_vec3(),
        };
        let step = sun.as_vec3() * self.length as f32;
        let spread = Vec3::splat((slope * self.length) as f32);
        let shaft = Shaft::along_direction(&start, step - spread, step + spread);
        let bvh = self.facets.geometry().bvh();
        bvh.in_shaft(&shaft, &mut CasterSearch(visit));
    }

    /// Passes the corners, relative to a point, of facets that may hide a part of a cone around the
    /// sun to `visit`, until it returns true. Facets that the point is on hide nothing.
    pub(crate) fn visit_in_cone(
        &self,
        p: DVec3,
        sun: DVec3,
        slope: f64,
        mut visit: impl FnMut([DVec3; 3]) -> bool,
    ) {
        self.visit_casters(p, sun, slope, |id| {
            let corners = self.facets.local_corners(id).map(|corner| corner - p);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            normal.dot(a).abs() > self.margin * normal.length() && visit(corners)
        });
    }
}

/// A search for casters that passes their ids on until the function returns true.
struct CasterSearch<F>(F);

impl<F: FnMut(u32) -> bool> ShaftSearch for CasterSearch<F> {
    #[inline(always)]
    fn keep(&mut self, entered: u32, _: [Vec4; 3], _: [Vec4; 3]) -> u32 {
        entered
    }

    #[inline(always)]
    fn visit(&mut self, id: u32, _: [Vec3; 3]) -> bool {
        (self.0)(id)
    }
}

struct RaySearch<'a> {
    rays: &'a Rays<'a>,
    p: DVec3,
    frame: &'a DMat3,
    is_hit: bool,
    is_near: bool,
    blocker: u32,
}

impl RaySearch<'_> {
    /// Tests a facet. Returns whether it certainly shades the point.
    #[inline(always)]
    fn test(&mut self, id: u32) -> bool {
        let margin = self.rays.margin;
        let corners = self
            .rays
            .facets
            .local_corners(id)
            .map(|corner| corner - self.p);
        let [a, b, c] = corners.map(|corner| self.frame.transpose_mul_vec3(corner).xy());
        // Twice the areas between the ray, seen as a point, and the sides. Facets that share a side
        // get the same bits with opposite signs, so there are no cracks.
        let areas = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let sign = f64::signum(areas[0] + areas[1] + areas[2]);
        let sides = [c - b, a - c, b - a];
        let mut is_inside = true;
        let mut is_certain = true;
        for (area, side) in areas.iter().zip(sides) {
            let area = area * sign;
            // The margin around the side. The sum of its coordinates is at least its length.
            let slack = margin * (side.x.abs() + side.y.abs());
            if area < -slack {
                return false;
            }
            is_inside &= area >= 0.0;
            is_certain &= area > slack;
        }
        if !shades(&corners, self.frame.z_axis, margin) {
            return false;
        }
        self.is_hit |= is_inside;
        self.is_near = true;
        if is_certain {
            self.blocker = id;
        }
        is_certain
    }
}

/// Returns whether a facet's plane is between the origin and the sun, farther from the origin than
/// the margin. Nearer facets are those that the point is on.
#[inline(always)]
fn shades(corners: &[DVec3; 3], sun: DVec3, margin: f64) -> bool {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    let distance = normal.dot(a) * normal.dot(sun).signum();
    // False for facets without an area.
    distance > margin * normal.length()
}
