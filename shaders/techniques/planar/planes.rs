//! The planes that receive shadows.

use crate::shading::facing::turned_away;
use glam::{DVec3, DVec4, Vec4};
use umbrage_core::{Camera, Geometry, Receivers, View};

/// Triangles lie in one plane if their corners are within this fraction of the geometry's greatest coordinate of it:
/// 2^-20, 8 units in the last place, what placing an instance may round.
pub(crate) const SAME_PLANE: f64 = 1.0 / 1_048_576.0;

/// The plane number of triangles in no plane.
pub(crate) const NO_PLANE: u32 = u32::MAX;

/// Planes, and which receiving triangle lies in which.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Planes {
    /// (n, d) with `n . p + d = 0`: unit normal towards the light, metres.
    pub(crate) planes: Vec<DVec4>,
    /// For each receiving triangle an index or [`NO_PLANE`].
    pub(crate) of_triangle: Vec<u32>,
    /// How far from a plane its points may be, metres.
    pub(crate) tolerance: f64,
}

impl Planes {
    /// The planes of the receiving triangles that the camera sees on the side that the light is on, the largest first.
    /// Stops looking once there are more than `most`.
    pub(crate) fn find(view: &View<'_>, geometry: &Geometry, light: Vec4, most: usize) -> Self {
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
            if out.planes.len() > most {
                break;
            }
        }
        out
    }

    /// The plane in which a triangle lies; its own is added if there is none.
    fn plane_of(&mut self, geometry: &Geometry, triangle: u32, light: Vec4) -> u32 {
        let corners = geometry.corners(triangle).map(|p| p.as_dvec3().extend(1.0));
        let holds = |plane: &DVec4| {
            corners
                .iter()
                .all(|p| plane.dot(*p).abs() <= self.tolerance)
        };
        if let Some(known) = self.planes.iter().position(holds) {
            return known as u32;
        }
        let n = normal(geometry, triangle).normalize();
        let plane = n.extend(-n.dot(corners[0].truncate()));
        let side = plane.dot(light.as_dvec4());
        self.planes.push(if side < 0.0 { -plane } else { plane });
        self.planes.len() as u32 - 1
    }
}

/// Twice the triangle's area long.
fn normal(geometry: &Geometry, triangle: u32) -> DVec3 {
    let [a, b, c] = geometry.corners(triangle).map(|p| p.as_dvec3());
    (b - a).cross(c - a)
}

/// Triangles of pixels that receive and face the light.
fn seen_lit(geometry: &Geometry, receivers: &Receivers, light: Vec4) -> Vec<u32> {
    let mut seen = vec![false; geometry.triangles().len()];
    for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
        if turned_away(light, receivers.position(i), receivers.normal(i)) == 0 {
            // Receivers may be the caller's: ids that name nothing are passed over.
            if let Some(seen) = seen.get_mut(receivers.triangle[i] as usize) {
                *seen = true;
            }
        }
    }
    geometry.receivers().filter(|&t| seen[t as usize]).collect()
}

/// Receiving triangles whose planes have eye and light on the same side.
fn facing_both(geometry: &Geometry, camera: &Camera, light: Vec4) -> Vec<u32> {
    let space = camera.space();
    let eye = if space.clip_from_view.row(3) == Vec4::W {
        space.view_from_world.row(2).truncate().extend(0.0)
    } else {
        camera.eye().extend(1.0)
    };
    let side = |triangle: u32, of: Vec4| {
        let a = geometry.corners(triangle)[0].as_dvec3();
        let of = of.as_dvec4();
        normal(geometry, triangle).dot(of.truncate() - a * of.w)
    };
    geometry
        .receivers()
        .filter(|&t| side(t, eye) * side(t, light) > 0.0)
        .collect()
}
