//! Near and far planes around the geometry visible to a camera or a spot light.

use crate::{
    geometry::{
        Geometry,
        aabb::Aabb,
        clip_polygon::{Polygon, edge_crossing},
    },
    light_space::view_box::ViewBox,
};
use glam::{DAffine3, DVec3, Mat4, Vec3};
use std::ops::Range;

/// Slack of the fitted planes, as a fraction of their distance. Rounding in a 32-bit projection is
/// near 1e-7, so nothing visible is clipped.
const RANGE_SLACK: f64 = 1e-3;
/// Least near plane, as a fraction of the far plane: 2^-20. Guards against zero, and is far below
/// the resolution of depth.
const MIN_NEAR_OVER_FAR: f64 = 1.0 / 1_048_576.0;

/// A triangle clipped by the four sides of a pyramid. It has at most seven corners. The other slots
/// are for corners that rounding adds where an edge runs along a side. With n corners of any sign,
/// at most 3n/2 are left: 3, 4, 6, 9, 13.
type CutTriangle = Polygon<DVec3, 13>;

/// View volume of a camera or a spot light: a pyramid with its apex at the eye, without near and
/// far planes.
#[derive(Clone, Copy, Debug)]
pub struct ViewPyramid {
    /// The view from world space: a rigid motion. It looks along -z.
    pub view_from_world: Mat4,
    /// Tangents of the half angles in x and y.
    pub tangents: [f64; 2],
}

impl ViewPyramid {
    /// Returns whether a world-space point is inside the pyramid. Allows for rounding by a
    /// thousandth of the pyramid's width at that depth.
    pub fn contains(&self, p: Vec3) -> bool {
        let p = DAffine3::from_mat4(self.view_from_world.as_dmat4()).transform_point3(p.as_dvec3());
        let padded_distance = -p.z * (1.0 + RANGE_SLACK);
        p.x.abs() <= padded_distance * self.tangents[0]
            && p.y.abs() <= padded_distance * self.tangents[1]
    }
}

/// Returns the distances, along the view, of planes just before and just behind the parts of
/// triangles (world space) in a pyramid. `None` if there are none.
pub fn depth_range(
    pyramid: &ViewPyramid,
    triangles: impl Iterator<Item = [Vec3; 3]>,
) -> Option<[f32; 2]> {
    let view_from_world = DAffine3::from_mat4(pyramid.view_from_world.as_dmat4());
    let mut near = f64::INFINITY;
    let mut far = 0.0_f64;
    for corners in triangles {
        let corners = corners.map(|p| view_from_world.transform_point3(p.as_dvec3()));
        for p in seen_part(&corners, pyramid.tangents).corners() {
            near = near.min(-p.z);
            far = far.max(-p.z);
        }
    }
    planes(near, far)
}

/// Returns the [`depth_range`] of a range of a geometry's triangles. Evaluates only those boxes
/// that may contain the nearest or the farthest part.
pub(crate) fn depth_range_of(
    pyramid: &ViewPyramid,
    geometry: &Geometry,
    triangles: Range<u32>,
) -> Option<[f32; 2]> {
    let view_from_world = DAffine3::from_mat4(pyramid.view_from_world.as_dmat4());
    let seen_corners = |id: u32| {
        let corners = geometry.corners(id);
        let in_view = corners.map(|p| view_from_world.transform_point3(p.as_dvec3()));
        seen_part(&in_view, pyramid.tangents)
    };
    let boxes = geometry.box_tree();
    // Find the least `sign` times the distance along the view, which looks along -z.
    let least = |sign: f64| {
        boxes.least(
            triangles.clone(),
            |b| least_distance(&view_from_world, pyramid.tangents, b, sign),
            |run, _| {
                boxes.count(&run);
                let mut least = f64::INFINITY;
                for id in run {
                    for p in seen_corners(id).corners() {
                        least = least.min(sign * -p.z);
                    }
                }
                least
            },
        )
    };
    let far = (-least(-1.0)).max(0.0);
    if far <= 0.0 {
        return None;
    }
    planes(least(1.0), far)
}

/// Returns a lower bound of `sign` (1 or -1) times the distance along the view, for the part of a
/// box in a pyramid. Infinity if there is no such part.
fn least_distance(view_from_world: &DAffine3, tangents: [f64; 2], b: &Aabb, sign: f64) -> f64 {
    let in_view = ViewBox::padded_box(view_from_world, b);
    let is_outside = side_normals(tangents)
        .iter()
        .any(|normal| normal.dot(in_view.center) + normal.abs().dot(in_view.half) < 0.0);
    if is_outside {
        return f64::INFINITY;
    }
    sign * -in_view.center.z - in_view.half.z
}

/// Returns the distances of planes just before `near` and just behind `far`, the distances of the
/// nearest and the farthest visible part. `None` if nothing is visible; `far` is then not positive.
fn planes(near: f64, far: f64) -> Option<[f32; 2]> {
    let far = far * (1.0 + RANGE_SLACK);
    if far <= 0.0 {
        return None;
    }
    let near = (near * (1.0 - RANGE_SLACK)).max(far * MIN_NEAR_OVER_FAR);
    Some([near as f32, far as f32])
}

/// Returns the inner normals, in view space, of the four sides of a pyramid, which meet in the eye.
fn side_normals(tangents: [f64; 2]) -> [DVec3; 4] {
    let [tangent_x, tangent_y] = tangents;
    [
        DVec3::new(1.0, 0.0, -tangent_x),
        DVec3::new(-1.0, 0.0, -tangent_x),
        DVec3::new(0.0, 1.0, -tangent_y),
        DVec3::new(0.0, -1.0, -tangent_y),
    ]
}

/// Returns the part of a triangle, in view space, inside the pyramid. The four sides meet in the
/// eye, so geometry behind it is removed.
fn seen_part(corners: &[DVec3; 3], tangents: [f64; 2]) -> CutTriangle {
    let side_normals = side_normals(tangents);
    // Most triangles are entirely outside one side.
    for normal in side_normals {
        if corners.iter().all(|p| normal.dot(*p) < 0.0) {
            return CutTriangle::empty();
        }
    }
    let mut polygon = CutTriangle::triangle(*corners);
    for normal in side_normals {
        polygon = polygon.clip(|p| normal.dot(p), edge_crossing);
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light_space::look_along;

    fn range(triangles: &[[Vec3; 3]]) -> Option<[f32; 2]> {
        let view_from_world = look_along(Vec3::new(0.0, 0.0, 10.0), Vec3::NEG_Z, Vec3::Y).unwrap();
        depth_range(
            &ViewPyramid {
                view_from_world,
                tangents: [1.0, 0.5],
            },
            triangles.iter().copied(),
        )
    }

    fn corners_at(z: f32, half: f32) -> [Vec3; 3] {
        [
            Vec3::new(-half, -half, z),
            Vec3::new(half, -half, z),
            Vec3::new(0.0, half, z),
        ]
    }

    #[test]
    fn planes_hug_what_is_seen() {
        let [near, far] = range(&[corners_at(8.0, 0.1), corners_at(-10.0, 0.1)]).unwrap();
        assert!(
            near < 2.0 && near > 1.99 && far > 20.0 && far < 20.1,
            "{near} {far}"
        );
    }

    #[test]
    fn what_is_next_to_or_behind_does_not_count() {
        let behind = corners_at(12.0, 0.1);
        let adjacent = corners_at(9.0, 0.1).map(|p| p + Vec3::X * 5.0);
        assert_eq!(range(&[behind, adjacent]), None);
        assert_eq!(
            range(&[behind, adjacent, corners_at(0.0, 0.1)]),
            range(&[corners_at(0.0, 0.1)])
        );
    }

    #[test]
    fn a_triangle_that_crosses_the_pyramid_counts_where_it_is_seen() {
        // The corners are far outside, but the middle fills the view 2 m ahead.
        assert_eq!(
            range(&[corners_at(8.0, 1e4)]),
            range(&[corners_at(8.0, 0.1)])
        );
        // A floor under the eye extends behind it. It is visible from where the lower side of the
        // pyramid meets it.
        let floor = [
            Vec3::new(-99.0, -2.0, 99.0),
            Vec3::new(99.0, -2.0, 99.0),
            Vec3::new(0.0, -2.0, -99.0),
        ];
        let [near, _] = range(&[floor]).unwrap();
        assert!(near < 4.0 && near > 3.99, "{near}");
    }

    #[test]
    fn a_surface_through_the_eye_leaves_a_usable_range() {
        let through = [
            Vec3::new(-1.0, 0.0, 20.0),
            Vec3::new(1.0, 0.0, 20.0),
            Vec3::new(0.0, 0.0, -20.0),
        ];
        let [near, far] = range(&[through]).unwrap();
        assert!(near > 0.0 && near < far);
    }

    #[test]
    fn scale_does_not_matter() {
        let scaled = |s: f32| {
            let eye = Vec3::new(0.0, 0.0, 10.0 * s);
            let view_from_world = look_along(eye, Vec3::NEG_Z, Vec3::Y).unwrap();
            let triangle = [corners_at(8.0, 0.1).map(|p| p * s)];
            let [near, far] = depth_range(
                &ViewPyramid {
                    view_from_world,
                    tangents: [1.0, 0.5],
                },
                triangle.into_iter(),
            )
            .unwrap();
            [near / s, far / s]
        };
        for s in [1e-6, 1e-3, 1e4, 1e8] {
            let a = scaled(1.0);
            let b = scaled(s);
            // Positions are rounded once to f32.
            assert!(
                (a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5,
                "{a:?} {b:?}"
            );
        }
    }
}
