//! Planes that receive shadows.

use crate::shading::facing::turned_away;
use glam::{DVec3, DVec4, Vec4};
use umbrage_core::{Camera, Geometry, Receivers, View};

/// Tolerance of planes: triangles are in one plane if their corners are within this fraction of the
/// geometry's greatest coordinate of it. 2^-20 is 8 units in the last place, the rounding of an
/// instance transform.
pub(crate) const SAME_PLANE: f64 = 1.0 / 1_048_576.0;

/// Plane number of triangles in no plane.
pub(crate) const NO_PLANE: u32 = u32::MAX;

/// Planes, and the plane of each receiving triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Planes {
    /// (n, d) with `n . p + d = 0`: unit normal towards the light, metres.
    pub(crate) planes: Vec<DVec4>,
    /// Plane index or [`NO_PLANE`] for each receiving triangle.
    pub(crate) of_triangle: Vec<u32>,
    /// Greatest distance of a plane's points from it, metres.
    pub(crate) tolerance: f64,
}

impl Planes {
    /// Finds the planes of the receiving triangles that the camera views from the light's side, the
    /// largest triangle's first. Stops once there are more than `max_count`.
    pub(crate) fn find(
        view: &View<'_>,
        geometry: &Geometry,
        light: Vec4,
        max_count: usize,
    ) -> Self {
        let wanted = match view.receivers {
            Some(receivers) => seen_lit(geometry, receivers, light),
            None => facing_both(geometry, view.camera, light),
        };
        let mut candidates: Vec<(f64, u32)> = wanted
            .into_iter()
            .map(|t| (normal(geometry, t).length(), t))
            .collect();
        candidates.retain(|&(area, _)| area > 0.0);
        candidates.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let bounds = geometry.bounds();
        let reach = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element());
        let mut out = Self {
            planes: Vec::new(),
            of_triangle: vec![NO_PLANE; geometry.receivers().len()],
            tolerance: SAME_PLANE * reach,
        };
        for (_, triangle) in candidates {
            let plane = out.plane_of(geometry, triangle, light);
            out.of_triangle[(triangle - geometry.receivers().start) as usize] = plane;
            if out.planes.len() > max_count {
                break;
            }
        }
        out
    }

    /// Returns the index of a triangle's plane. Adds the plane if it is not known yet.
    fn plane_of(&mut self, geometry: &Geometry, triangle: u32, light: Vec4) -> u32 {
        let corners = geometry.corners(triangle).map(|p| p.as_dvec3().extend(1.0));
        for (i, plane) in (0..).zip(&self.planes) {
            let distances = corners.map(|p| plane.dot(p).abs());
            if distances.iter().all(|&d| d <= self.tolerance) {
                return i;
            }
        }
        let n = normal(geometry, triangle).normalize();
        let plane = n.extend(-n.dot(corners[0].truncate()));
        let side = plane.dot(light.as_dvec4());
        self.planes.push(if side < 0.0 { -plane } else { plane });
        self.planes.len() as u32 - 1
    }
}

/// Returns a triangle's normal, whose length is twice the area.
fn normal(geometry: &Geometry, triangle: u32) -> DVec3 {
    let [a, b, c] = geometry.corners(triangle).map(|p| p.as_dvec3());
    (b - a).cross(c - a)
}

/// Returns the triangles of pixels that receive and face the light.
fn seen_lit(geometry: &Geometry, receivers: &Receivers, light: Vec4) -> Vec<u32> {
    let mut seen = vec![false; geometry.triangles().len()];
    for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
        if turned_away(light, receivers.position(i), receivers.normal(i)) == 0 {
            // Receivers may come from the caller: skip unknown ids.
            if let Some(seen) = seen.get_mut(receivers.triangle[i] as usize) {
                *seen = true;
            }
        }
    }
    geometry.receivers().filter(|&t| seen[t as usize]).collect()
}

/// Returns the receiving triangles whose planes have eye and light on the same side.
fn facing_both(geometry: &Geometry, camera: &Camera, light: Vec4) -> Vec<u32> {
    let space = camera.space();
    let eye = if space.clip_from_view.row(3) == Vec4::W {
        space.view_from_world.row(2).truncate().extend(0.0)
    } else {
        camera.eye().extend(1.0)
    };
    geometry
        .receivers()
        .filter(|&t| side(geometry, t, eye) * side(geometry, t, light) > 0.0)
        .collect()
}

/// Returns the side of a triangle's plane that contains a homogeneous point or direction: positive
/// in front, negative behind.
fn side(geometry: &Geometry, triangle: u32, point: Vec4) -> f64 {
    let corner = geometry.corners(triangle)[0].as_dvec3();
    let point = point.as_dvec4();
    normal(geometry, triangle).dot(point.truncate() - corner * point.w)
}
