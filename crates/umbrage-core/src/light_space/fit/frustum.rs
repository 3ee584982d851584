//! The view volume of a camera, divided into slices by depth.

use crate::{
    geometry::{
        aabb::Aabb,
        clip_polygon::{Polygon, edge_crossing},
    },
    scene::camera::Camera,
};
use glam::{DAffine3, DVec3, Mat4, Vec3, Vec4};

/// A face of a slice or of a box, clipped by the six planes of the other: four corners and one more
/// for each plane. The other slots are for corners that rounding adds.
type CutFace = Polygon<DVec3, 16>;

/// A camera's pyramid (a box without perspective), beginning at its near plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraFrustum {
    pub(super) world_from_view: DAffine3,
    view_from_world: DAffine3,
    /// Corners of the near plane, view space.
    pub(super) near_corners: [DVec3; 4],
    perspective: bool,
    /// Distance of the far plane along the view; infinity if there is none.
    far: f64,
}

/// A range of distances along a camera's view, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slice {
    pub(crate) begin: f64,
    pub(crate) end: f64,
}

/// A slice of a camera's view, for tests of world-space points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SliceOfView {
    view_from_world: DAffine3,
    slice: Slice,
}

impl SliceOfView {
    /// Returns whether a point (world space) is in the slice.
    #[inline]
    pub(crate) fn holds(&self, p: Vec3) -> bool {
        let distance = distance_along(&self.view_from_world, p.as_dvec3());
        distance >= self.slice.begin && distance <= self.slice.end
    }

    /// Returns whether all points of a box are in the slice.
    pub(crate) fn holds_all_of(&self, b: &Aabb) -> bool {
        b.corners().all(|corner| self.holds(corner))
    }

    /// Returns whether no point of a box is in the slice.
    pub(crate) fn holds_none_of(&self, b: &Aabb) -> bool {
        let distances = b
            .corners()
            .map(|corner| distance_along(&self.view_from_world, corner.as_dvec3()));
        let mut least = f64::INFINITY;
        let mut greatest = f64::NEG_INFINITY;
        for distance in distances {
            least = least.min(distance);
            greatest = greatest.max(distance);
        }
        !(least <= self.slice.end && greatest >= self.slice.begin)
    }
}

/// Returns the distance of a world-space point along a view, which looks along -z.
#[inline]
fn distance_along(view_from_world: &DAffine3, p: DVec3) -> f64 {
    let m = &view_from_world.matrix3;
    let along_z =
        m.x_axis.z * p.x + m.y_axis.z * p.y + m.z_axis.z * p.z + view_from_world.translation.z;
    -along_z
}

impl CameraFrustum {
    pub(super) fn new(camera: &Camera) -> Self {
        let camera = camera.standard();
        let view_from_clip = camera.clip_from_view.as_dmat4().inverse();
        let far_plane = -view_from_clip.project_point3(DVec3::Z).z;
        // A far plane at infinity is computed as infinite, or negative due to the rounding of the
        // inverse.
        let far = if far_plane.is_finite() && far_plane > 0.0 {
            far_plane
        } else {
            f64::INFINITY
        };
        let world_from_view = DAffine3::from_mat4(Mat4::from(camera.world_from_view).as_dmat4());
        Self {
            world_from_view,
            view_from_world: world_from_view.inverse(),
            near_corners: [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                .map(|(x, y)| view_from_clip.project_point3(DVec3::new(x, y, 0.0))),
            perspective: camera.clip_from_view.row(3) != Vec4::W,
            far,
        }
    }

    /// Returns the distance of the near plane along the view; that of its nearest corner if the
    /// plane is oblique.
    pub(super) fn near_distance(&self) -> f64 {
        let distances = self.near_corners.map(|corner| -corner.z);
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Returns the direction along the view, world space.
    pub(super) fn forward(&self) -> Vec3 {
        (-self.world_from_view.matrix3.z_axis).as_vec3()
    }

    pub(super) fn has_perspective(&self) -> bool {
        self.perspective
    }

    /// Returns a distance along the view, limited to the far plane.
    pub(super) fn before_far(&self, distance: f64) -> f64 {
        distance.min(self.far)
    }

    /// Returns the corners of the view at a distance along it, at least that of the near plane;
    /// view space.
    pub(super) fn corners_at(&self, distance: f64) -> [DVec3; 4] {
        self.near_corners.map(|near| {
            let distance = distance.max(-near.z);
            if self.perspective {
                near * (distance / -near.z)
            } else {
                near.with_z(-distance)
            }
        })
    }

    /// Returns a test for points in a slice.
    pub(super) fn slice_of_view(&self, slice: Slice) -> SliceOfView {
        SliceOfView {
            view_from_world: self.view_from_world,
            slice,
        }
    }

    /// Returns the distance of a world-space point along the view.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        distance_along(&self.view_from_world, p)
    }

    /// Returns the range of distances along the view of the visible part of a box; `None` if it
    /// isn't visible.
    pub(super) fn seen_part(&self, b: &Aabb) -> Option<Slice> {
        if b.is_empty() {
            return None;
        }
        let corners = b.corners().map(|corner| self.distance(corner.as_dvec3()));
        let farthest_corner = corners.fold(0.0, f64::max);
        let all = Slice {
            begin: self.near_distance(),
            end: self.before_far(farthest_corner),
        };
        self.range_of(&self.part_of_box(all, b))
    }

    /// Returns the range of distances of points (world space) along the view; `None` without
    /// points.
    pub(super) fn range_of(&self, points: &[DVec3]) -> Option<Slice> {
        let mut range = Slice {
            begin: f64::INFINITY,
            end: f64::NEG_INFINITY,
        };
        for &p in points {
            let distance = self.distance(p);
            range.begin = range.begin.min(distance);
            range.end = range.end.max(distance);
        }
        (range.begin <= range.end).then_some(range)
    }

    /// Returns the eight corners of a slice, world space: the nearer four first.
    pub(super) fn slice_corners(&self, slice: Slice) -> [DVec3; 8] {
        let near = self.corners_at(slice.begin);
        let far = self.corners_at(slice.end);
        std::array::from_fn(|i| self.in_world(if i < 4 { near[i] } else { far[i - 4] }))
    }

    /// Returns the corners (world space) of the intersection of a slice of the view and a box;
    /// empty if they don't meet.
    pub(super) fn part_of_box(&self, slice: Slice, b: &Aabb) -> Vec<DVec3> {
        if b.is_empty() {
            return Vec::new();
        }
        self.part_of_body(slice, box_corners(b.min.as_dvec3(), b.max.as_dvec3()))
    }

    /// Returns the corners (world space) of the intersection of a slice of the view and a turned
    /// box with these corners, in the order of [`box_corners`]; empty if they don't meet.
    pub(super) fn part_of_body(&self, slice: Slice, corners: [DVec3; 8]) -> Vec<DVec3> {
        if slice.begin >= slice.end {
            return Vec::new();
        }
        let slice = Hexahedron::new(self.slice_corners(slice));
        let body = Hexahedron::new(corners);
        // Each corner of the intersection is on a face of one of them.
        let mut out = slice.corners_within(&body);
        out.extend(body.corners_within(&slice));
        out
    }

    fn in_world(&self, p: DVec3) -> DVec3 {
        self.world_from_view.transform_point3(p)
    }
}

/// Returns the corners of a box: corner `i` is at the greater x if bit 0 of `i` is set, y bit 1, z
/// bit 2.
pub(super) fn box_corners(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let far_side = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        min + (max - min) * far_side
    })
}

/// A convex body with six faces of four corners, in the order of [`box_corners`].
struct Hexahedron {
    corners: [DVec3; 8],
    /// Planes of the faces. For a point on the inner side, the product with the normal is at least
    /// the distance.
    planes: [(DVec3, f64); 6],
}

impl Hexahedron {
    /// Corners of the faces, in order around each.
    const FACES: [[usize; 4]; 6] = [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ];

    fn new(corners: [DVec3; 8]) -> Self {
        let middle = corners.iter().sum::<DVec3>() / 8.0;
        let planes = Self::FACES.map(|[a, b, c, d]| {
            // Use both diagonals: a side may have no length.
            let normal = (corners[c] - corners[a])
                .cross(corners[d] - corners[b])
                .normalize_or_zero();
            let inwards = if normal.dot(middle - corners[a]) < 0.0 {
                -normal
            } else {
                normal
            };
            (inwards, inwards.dot(corners[a]))
        });
        Self { corners, planes }
    }

    /// Returns the corners of this body's faces, clipped to another body.
    fn corners_within(&self, other: &Self) -> Vec<DVec3> {
        let mut out = Vec::new();
        for face in Self::FACES {
            let mut part = CutFace::from_corners(face.map(|corner| self.corners[corner]));
            for (normal, distance) in other.planes {
                part = part.clip(|p| normal.dot(p) - distance, edge_crossing);
            }
            out.extend_from_slice(part.corners());
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// Returns a view along -z from the origin, 90 degrees each way.
    fn frustum() -> CameraFrustum {
        let camera = Camera::perspective(
            Vec3::ZERO,
            Vec3::NEG_Z,
            Vec3::Y,
            std::f32::consts::FRAC_PI_2,
            [1.0, 100.0],
            UVec2::splat(8),
        )
        .expect("valid");
        CameraFrustum::new(&camera)
    }

    fn bounds(points: &[DVec3]) -> [DVec3; 2] {
        let min = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let max = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        [min, max]
    }

    #[test]
    fn a_slice_in_a_box_and_a_box_in_a_slice_are_whole() {
        let slice = Slice {
            begin: 2.0,
            end: 10.0,
        };
        let everything = Aabb {
            min: Vec3::splat(-99.0),
            max: Vec3::splat(99.0),
        };
        let [min, max] = bounds(&frustum().part_of_box(slice, &everything));
        assert!(
            (min - DVec3::splat(-10.0)).abs().max_element() < 1e-4,
            "{min}"
        );
        assert!((max - DVec3::new(10.0, 10.0, -2.0)).abs().max_element() < 1e-4);
        let inside = Aabb {
            min: Vec3::new(-1.0, -1.0, -5.0),
            max: Vec3::new(1.0, 1.0, -3.0),
        };
        let [min, max] = bounds(&frustum().part_of_box(slice, &inside));
        assert_eq!([min.as_vec3(), max.as_vec3()], [inside.min, inside.max]);
        assert!(frustum().part_of_box(slice, &Aabb::EMPTY).is_empty());
    }

    #[test]
    fn a_floor_is_seen_from_where_the_view_meets_it() {
        let floor = Aabb {
            min: Vec3::new(-50.0, -4.0, -50.0),
            max: Vec3::new(50.0, -4.0, 50.0),
        };
        let part = frustum().seen_part(&floor).expect("seen");
        assert!((part.begin - 4.0).abs() < 1e-4, "{part:?}");
        assert!((part.end - 50.0).abs() < 1e-4, "{part:?}");
        let above = Aabb {
            min: Vec3::new(-1.0, 60.0, -50.0),
            max: Vec3::new(1.0, 61.0, 50.0),
        };
        assert_eq!(frustum().seen_part(&above), None);
    }
}
