//! Casters flattened onto a plane.

use crate::techniques::planar::matrix::exact;
use glam::{DMat4, DVec3, DVec4};
use umbrage_core::{Faces, Geometry, light_sample::SHORT};

/// Triangles within this angle (sine) of the light's ray are edge-on to it and hide nothing.
const EDGE_ON: f64 = 1e-6;

/// Slab between a plane and the light, in which casters cast shadows on the plane.
struct Slab {
    plane: DVec4,
    light: DVec4,
    /// Just above the plane, so that triangles in it do not cast.
    low: f64,
    /// Just below the light, where rays end; infinite for directions.
    high: f64,
}

/// Returns all casters' shadows on a plane (unit normal towards the light), as points on it.
/// Casters are clipped at the plane and at the light's height.
pub(crate) fn flatten_casters(
    geometry: &Geometry,
    plane: DVec4,
    light: DVec4,
    tolerance: f64,
) -> Faces {
    let height = plane.dot(light);
    let high = if light.w == 0.0 {
        f64::INFINITY
    } else {
        height * f64::from(SHORT)
    };
    let slab = Slab {
        plane,
        light,
        low: tolerance,
        high,
    };
    let onto_plane = exact(plane, light);
    let mut faces = Faces::default();
    for triangle in geometry.casters() {
        let polygon = slab.clip(geometry.corners(triangle).map(|p| p.as_dvec3()));
        add_shadow(&polygon, &onto_plane, &mut faces);
    }
    faces
}

/// Adds the shadow of a convex polygon, as a fan of triangles.
fn add_shadow(polygon: &[DVec3], onto_plane: &DMat4, faces: &mut Faces) {
    let first = faces.vertices.len() as u32;
    for p in polygon {
        let shadow = *onto_plane * p.extend(1.0);
        faces.vertices.push((shadow / shadow.w).as_vec4());
    }
    for i in 2..polygon.len() as u32 {
        faces.triangles.push([first, first + i - 1, first + i]);
    }
}

impl Slab {
    /// Returns the part of a triangle inside the slab: Sutherland and Hodgman 1974, "Reentrant
    /// polygon clipping".
    fn clip(&self, corners: [DVec3; 3]) -> Vec<DVec3> {
        let heights = corners.map(|p| self.height(p));
        let all_below = heights.iter().all(|&h| h <= self.low);
        let all_above = heights.iter().all(|&h| h >= self.high);
        if all_below || all_above || self.is_edge_on(corners) {
            return Vec::new();
        }
        if heights.iter().all(|&h| h >= self.low && h <= self.high) {
            return corners.to_vec();
        }
        let above_plane = cut_polygon(&corners, |p| self.height(p) - self.low);
        if self.high.is_finite() {
            cut_polygon(&above_plane, |p| self.high - self.height(p))
        } else {
            above_plane
        }
    }

    /// Returns the height of a point above the plane, metres.
    fn height(&self, p: DVec3) -> f64 {
        self.plane.dot(p.extend(1.0))
    }

    fn is_edge_on(&self, corners: [DVec3; 3]) -> bool {
        let [a, b, c] = corners;
        let n = (b - a).cross(c - a);
        let to_light = self.light.truncate() - a * self.light.w;
        n.dot(to_light).abs() <= EDGE_ON * n.length() * to_light.length()
    }
}

/// Returns the part of a polygon where `inside` is not negative. Crossings are measured from the
/// inner end for both edge directions, so that neighbours get the same one.
fn cut_polygon(polygon: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let at_p = inside(p);
        let at_q = inside(q);
        if at_p >= 0.0 {
            out.push(p);
        }
        if (at_p >= 0.0) != (at_q >= 0.0) {
            out.push(if at_p >= 0.0 {
                crossing_point(p, at_p, q, at_q)
            } else {
                crossing_point(q, at_q, p, at_p)
            });
        }
    }
    out
}

/// Returns the intersection of an edge with the border, from the values of `inside` at its ends.
fn crossing_point(inner: DVec3, at_inner: f64, outer: DVec3, at_outer: f64) -> DVec3 {
    inner.lerp(outer, at_inner / (at_inner - at_outer))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine3A, Vec3};
    use umbrage_core::{Instance, Mesh, Scene};

    const FLOOR: DVec4 = DVec4::new(0.0, 1.0, 0.0, 0.0);

    fn shadows(corners: [[f32; 3]; 3], light: DVec4) -> Faces {
        let mesh = Mesh::new("one", corners.map(Vec3::from).to_vec(), vec![[0, 1, 2]]).unwrap();
        let scene = Scene {
            meshes: vec![mesh],
            instances: vec![Instance::new(0, Affine3A::IDENTITY)],
            ..Scene::default()
        };
        flatten_casters(&Geometry::bake(&scene).unwrap(), FLOOR, light, 1e-6)
    }

    #[test]
    fn casters_below_or_above_throw_nothing() {
        let lamp = DVec4::new(0.0, 2.0, 0.0, 1.0);
        assert_eq!(
            shadows([[0.0, -1.0, 0.0], [1.0, -2.0, 0.0], [0.0, -1.0, 1.0]], lamp),
            Faces::default()
        );
        assert_eq!(
            shadows([[0.0, 3.0, 0.0], [1.0, 4.0, 0.0], [0.0, 3.0, 1.0]], lamp),
            Faces::default()
        );
        assert_eq!(
            shadows([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], lamp),
            Faces::default()
        );
        let through = [[0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [0.0, 1.0, 1.0]];
        assert_eq!(shadows(through, lamp), Faces::default(), "seen edge-on");
    }

    /// A triangle from below the floor to above the light becomes a quad on the floor, in front of
    /// the light.
    #[test]
    fn casters_that_cross_are_cut_on_both_sides() {
        let out = shadows(
            [[1.0, -1.0, -1.0], [1.0, -1.0, 1.0], [1.0, 3.0, 0.0]],
            DVec4::new(0.0, 2.0, 0.0, 1.0),
        );
        assert_eq!((out.vertices.len(), out.triangles.len()), (4, 2));
        assert!(
            out.vertices
                .iter()
                .all(|v| v.w == 1.0 && v.y.abs() < 1e-3 && v.x > 0.999_999),
            "{out:?}"
        );
        // At the floor it keeps its position: halfway along the first quarter of its upper edges.
        assert!(
            out.vertices
                .iter()
                .filter(|v| v.x < 1.000_01 && (v.z.abs() - 0.75).abs() < 1e-5)
                .count()
                == 2
        );
    }
}
