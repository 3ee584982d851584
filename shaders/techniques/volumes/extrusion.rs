//! Faces of the shadow volumes of a silhouette.
//!
//! Crow 1977, "Shadow algorithms for computer graphics"; McGuire, Hughes, Egan, Kilgard and Everitt
//! 2003, "Fast, practical and robust shadows": walls from edges to beyond all geometry, and caps at
//! both ends.
//!
//! Those papers end the volumes at infinity, by vertices with w = 0. An edge between two of these
//! that crosses the eye's plane has clip z = w = 0 there. Hardware clips at the near plane first,
//! which creates a vertex at that point. Rounding moves its w to either side of 0. An NVIDIA H200
//! then loses the depth of the face, and a quarter of an image is in a false shadow (the CPU
//! backend's `Clipping::ZeroWBehind` reproduces this). So all vertices here are finite.

use crate::techniques::volumes::{
    clip_window::{ClipWindow, Crossing, VisiblePart, VisibleParts},
    silhouette::{NetEdge, Silhouette, Welded},
};
use glam::{DVec3, DVec4, Vec3, Vec4};
use umbrage_core::{Aabb, Faces};

/// Returns the volumes' faces, counter-clockwise from outside, which end `reach` metres beyond
/// their casters. Each wall is repeated as often as its edge counts, and clipped to the window.
pub(crate) fn extrude(
    mesh: &Welded,
    silhouette: &Silhouette,
    light: DVec4,
    window: Option<&ClipWindow>,
    reach: f64,
) -> Faces {
    let far = FarVertices {
        first: mesh.positions.len() as u32,
    };
    let mut faces = Faces {
        vertices: mesh.positions.iter().map(|p| p.extend(1.0)).collect(),
        triangles: Vec::new(),
    };
    let far_vertices = mesh.positions.iter().map(|p| moved_away(*p, light, reach));
    faces.vertices.extend(far_vertices);
    for cap in &silhouette.caps {
        far.add_caps(cap.corners, &mut faces.triangles);
    }
    let mut parts = VisibleParts::default();
    for edge in &silhouette.edges {
        let mut visible = [VisiblePart::WHOLE; 2];
        if let Some(window) = window {
            visible[0] = far.visible_part(edge.from, window, &mut parts, &mut faces.vertices);
            visible[1] = far.visible_part(edge.to, window, &mut parts, &mut faces.vertices);
        }
        for _ in 0..edge.count {
            far.add_wall(edge, visible, &mut faces.triangles);
        }
    }
    faces
}

/// Returns a vertex moved away from the light by `reach` metres.
fn moved_away(p: Vec3, light: DVec4, reach: f64) -> Vec4 {
    let p = p.as_dvec3();
    let direction = p * light.w - light.truncate();
    let moved = p + direction.normalize_or_zero() * reach;
    moved.as_vec3().extend(1.0)
}

/// Least distance of far caps, as a fraction of the volumes' reach: a smaller one would reduce the
/// precision of the vertices.
const MIN_NEAREST: f64 = 1.0 / 1024.0;

/// Returns a distance from their casters at which volumes may end, metres. Their far caps are then
/// beyond the bounds of the scene, away from the light.
pub(crate) fn beyond_all(
    bounds: &Aabb,
    mesh: &Welded,
    silhouette: &Silhouette,
    light: DVec4,
) -> f64 {
    let corners = bounds.corners().map(|p| p.as_dvec3());
    if light.w == 0.0 {
        let mut min = f64::INFINITY;
        let mut max = f64::NEG_INFINITY;
        for corner in corners {
            let along = corner.dot(light.truncate());
            min = min.min(along);
            max = max.max(along);
        }
        return 2.0 * (max - min).max(f64::MIN_POSITIVE);
    }
    let lamp = light.truncate();
    let farthest = corners.map(|p| p.distance(lamp)).fold(0.0, f64::max);
    let mut nearest = 1.0_f64;
    for cap in &silhouette.caps {
        let to_corners = cap.corners.map(|v| {
            let to_corner = mesh.positions[v as usize].as_dvec3() - lamp;
            to_corner.normalize_or_zero()
        });
        nearest = nearest.min(distance_to_triangle(to_corners));
    }
    2.0 * farthest / nearest.max(MIN_NEAREST)
}

/// Returns the distance from the origin to a triangle whose corners are on the unit sphere.
fn distance_to_triangle(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    // The origin projects into the triangle if the normal is in the cone of its corners.
    let sides = edges.map(|(p, q)| normal.dot(p.cross(q)));
    let over_triangle = sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0);
    if over_triangle {
        return normal.normalize().dot(a).abs();
    }
    // The ends of a chord are equally far away, so its midpoint is the nearest.
    edges
        .map(|(p, q)| 0.5 * (p + q).length())
        .into_iter()
        .fold(1.0, f64::min)
}

/// Returns the caps that the scene does not contain with the same order of corners. Their depths
/// must be drawn in addition to the scene's.
pub(crate) fn caps_not_in_scene(mesh: &Welded, silhouette: &Silhouette) -> Faces {
    let missing = silhouette.caps.iter().filter(|cap| !cap.in_scene);
    let triangles: Vec<[u32; 3]> = missing.map(|cap| cap.corners).collect();
    let vertices = if triangles.is_empty() {
        Vec::new()
    } else {
        mesh.positions.iter().map(|p| p.extend(1.0)).collect()
    };
    Faces {
        vertices,
        triangles,
    }
}

/// Far ends of the volumes among the vertices.
struct FarVertices {
    /// Index of the first.
    first: u32,
}

impl FarVertices {
    /// Returns the far vertex of a caster's vertex.
    fn far_vertex(&self, near: u32) -> u32 {
        self.first + near
    }

    /// Adds the caps at the caster and at the far end.
    fn add_caps(&self, corners: [u32; 3], triangles: &mut Vec<[u32; 3]>) {
        let [a, b, c] = corners;
        triangles.push([a, b, c]);
        triangles.push([self.far_vertex(a), self.far_vertex(c), self.far_vertex(b)]);
    }

    /// Returns the part within the window of the edge from a vertex to its far end. Adds the
    /// vertices where it is cut.
    fn visible_part(
        &self,
        v: u32,
        window: &ClipWindow,
        parts: &mut VisibleParts,
        vertices: &mut Vec<Vec4>,
    ) -> VisiblePart<u32> {
        let from = vertices[v as usize].as_dvec4().truncate();
        let to = vertices[self.far_vertex(v) as usize].as_dvec4().truncate();
        let add_vertex = |at: DVec3| {
            vertices.push(at.as_vec3().extend(1.0));
            vertices.len() as u32 - 1
        };
        parts.edge_part(v, || window.visible_part(from, to), add_vertex)
    }

    /// Adds the wall of an edge. The cap has the edge from `from` to `to`, so the wall has it from
    /// `to` to `from`. The wall is cut where the edges to both far ends cross the window. Parts
    /// beyond one of its planes are dropped.
    fn add_wall(
        &self,
        edge: &NetEdge,
        visible: [VisiblePart<u32>; 2],
        triangles: &mut Vec<[u32; 3]>,
    ) {
        let near = [edge.from, edge.to];
        let far = near.map(|v| self.far_vertex(v));
        let [a, b] = visible;
        let enter = [
            a.enters.map_or(near[0], |c| c.at),
            b.enters.map_or(near[1], |c| c.at),
        ];
        let leave = [
            a.leaves.map_or(far[0], |c| c.at),
            b.leaves.map_or(far[1], |c| c.at),
        ];
        if !cross_same_plane(a.enters, b.enters) {
            add_strip(near, enter, triangles);
        }
        add_strip(enter, leave, triangles);
        if !cross_same_plane(a.leaves, b.leaves) {
            add_strip(leave, far, triangles);
        }
    }
}

/// Returns whether both edges cross the window at the same plane.
fn cross_same_plane(a: Option<Crossing<u32>>, b: Option<Crossing<u32>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.plane == b.plane,
        _ => false,
    }
}

/// Adds the part of a wall between two edges, `near` and `far`, without degenerate triangles.
fn add_strip(near: [u32; 2], far: [u32; 2], triangles: &mut Vec<[u32; 3]>) {
    let [a, b] = near;
    let [far_a, far_b] = far;
    if a != far_a && b != far_a {
        triangles.push([b, a, far_a]);
    }
    if b != far_b && far_a != far_b {
        triangles.push([b, far_a, far_b]);
    }
}
