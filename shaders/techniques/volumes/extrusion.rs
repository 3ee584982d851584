//! Shadow volumes of a silhouette, as faces to draw.
//!
//! Crow 1977, "Shadow algorithms for computer graphics"; McGuire, Hughes, Egan, Kilgard and Everitt 2003, "Fast,
//! practical and robust shadows": walls from edges to infinity, and caps at both ends. Infinity is one point for a
//! directional light, so that its walls are triangles and there is nothing to cap there. Volumes may also end at a distance
//! beyond all there is.

use crate::techniques::volumes::{
    silhouette::{Silhouette, Welded},
    window::{Crossing, Part, Parts, Window},
};
use glam::{DVec3, DVec4, Vec4};
use umbrage_core::{Aabb, Faces};

/// The volumes' faces, counter-clockwise seen from outside. Each wall comes as often as its edge counts, as far as it is in the
/// window. With a reach, the volumes end so many metres beyond their casters.
pub(crate) fn extrude(
    mesh: &Welded,
    silhouette: &Silhouette,
    light: DVec4,
    window: Option<&Window>,
    reach: Option<f64>,
) -> Faces {
    let far = Far {
        first: mesh.positions.len() as u32,
        is_one_point: light.w == 0.0 && reach.is_none(),
    };
    let mut faces = Faces {
        vertices: mesh.positions.iter().map(|p| p.extend(1.0)).collect(),
        triangles: Vec::new(),
    };
    let away = |p: &glam::Vec3| {
        let p = p.as_dvec3();
        let direction = p * light.w - light.truncate();
        match reach {
            None => direction.as_vec3().extend(0.0),
            Some(reach) => (p + direction.normalize_or_zero() * reach)
                .as_vec3()
                .extend(1.0),
        }
    };
    if far.is_one_point {
        faces.vertices.push((-light).as_vec4());
    } else {
        faces.vertices.extend(mesh.positions.iter().map(away));
    }
    for cap in &silhouette.caps {
        far.add_caps(cap.corners, &mut faces.triangles);
    }
    let mut parts = Parts::default();
    for &(edge, count) in &silhouette.edges {
        let within = edge.map(|v| match window {
            Some(window) => far.part(v, window, &mut parts, &mut faces.vertices),
            None => Part::WHOLE,
        });
        (0..count).for_each(|_| far.add_wall(edge, within, &mut faces.triangles));
    }
    faces
}

/// Far caps come no nearer than this fraction of the volumes' reach: more would cost vertices their precision.
const NEAREST: f64 = 1.0 / 1024.0;

/// A distance from their casters at which volumes may end: their far caps lie beyond the bounds of all there is, as seen from
/// the light.
pub(crate) fn beyond_all(
    bounds: &Aabb,
    mesh: &Welded,
    silhouette: &Silhouette,
    light: DVec4,
) -> f64 {
    let corners = || bounds.corners().map(|p| p.as_dvec3());
    if light.w == 0.0 {
        let along = corners().map(|p| p.dot(light.truncate()));
        let [least, most] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], d| {
            [a.min(d), b.max(d)]
        });
        return 2.0 * (most - least).max(f64::MIN_POSITIVE);
    }
    let lamp = light.truncate();
    let farthest = corners().map(|p| p.distance(lamp)).fold(0.0, f64::max);
    // All corners of a cap lie within some angle of its normal as seen from the lamp; in its middle, the far cap is nearer than
    // the reach by that angle's cosine.
    let cosine = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize].as_dvec3() - lamp);
        let height = (b - a).cross(c - a).normalize_or_zero().dot(a).abs();
        height / a.length().max(b.length()).max(c.length())
    };
    let nearest = silhouette
        .caps
        .iter()
        .map(|cap| cosine(cap.corners))
        .fold(1.0, f64::min);
    2.0 * farthest / nearest.max(NEAREST)
}

/// The caps that the scene does not have as they are.
pub(crate) fn caps_apart(mesh: &Welded, silhouette: &Silhouette) -> Faces {
    let apart = silhouette.caps.iter().filter(|cap| !cap.in_scene);
    let triangles: Vec<[u32; 3]> = apart.map(|cap| cap.corners).collect();
    let point = |p: &glam::Vec3| -> Vec4 { p.extend(1.0) };
    let vertices = if triangles.is_empty() {
        Vec::new()
    } else {
        mesh.positions.iter().map(point).collect()
    };
    Faces {
        vertices,
        triangles,
    }
}

/// Where the points at infinity are among the vertices.
struct Far {
    first: u32,
    is_one_point: bool,
}

impl Far {
    fn of(&self, near: u32) -> u32 {
        if self.is_one_point {
            self.first
        } else {
            self.first + near
        }
    }

    fn add_caps(&self, [a, b, c]: [u32; 3], triangles: &mut Vec<[u32; 3]>) {
        triangles.push([a, b, c]);
        if !self.is_one_point {
            triangles.push([self.of(a), self.of(c), self.of(b)]);
        }
    }

    /// The part within the window of the edge from a vertex to its point at infinity.
    fn part(
        &self,
        v: u32,
        window: &Window,
        parts: &mut Parts,
        vertices: &mut Vec<Vec4>,
    ) -> Part<u32> {
        let [from, to] = [v, self.of(v)].map(|v| vertices[v as usize].as_dvec4());
        let add = |at: DVec3| {
            vertices.push(at.as_vec3().extend(1.0));
            vertices.len() as u32 - 1
        };
        parts.of(v, || window.part(from.truncate(), to), add)
    }

    /// The cap has the edge from `a` to `b`, so the wall next to it has it from `b` to `a`. The wall is cut where the edges to
    /// both points at infinity cross the window; what lies beyond one of its planes is left out.
    fn add_wall(&self, near: [u32; 2], within: [Part<u32>; 2], triangles: &mut Vec<[u32; 3]>) {
        let far = near.map(|v| self.of(v));
        let [a, b] = within;
        let enter = [
            a.enters.map_or(near[0], |c| c.at),
            b.enters.map_or(near[1], |c| c.at),
        ];
        let leave = [
            a.leaves.map_or(far[0], |c| c.at),
            b.leaves.map_or(far[1], |c| c.at),
        ];
        let same_plane =
            |c: [Option<Crossing<u32>>; 2]| c[0].zip(c[1]).is_some_and(|(a, b)| a.plane == b.plane);
        if !same_plane([a.enters, b.enters]) {
            add_strip(near, enter, triangles);
        }
        add_strip(enter, leave, triangles);
        if !same_plane([a.leaves, b.leaves]) {
            add_strip(leave, far, triangles);
        }
    }
}

/// A wall's part between two edges that run alike, but for triangles without area.
fn add_strip([a, b]: [u32; 2], [far_a, far_b]: [u32; 2], triangles: &mut Vec<[u32; 3]>) {
    if a != far_a && b != far_a {
        triangles.push([b, a, far_a]);
    }
    if b != far_b && far_a != far_b {
        triangles.push([b, far_a, far_b]);
    }
}
