//! Closed convex parts of a scene, such as boxes and balls. The backs of their triangles are never
//! visible from outside, so software rasterisers, whose time is proportional to the number of
//! triangles, can cull them. Other parts may be open or show their backs through folds, so all of
//! their triangles are drawn.

use std::collections::HashMap;
use umbrage::{Aabb, Geometry, glam::Vec3};

/// Greatest number of triangles of a candidate part, since the test takes quadratic time.
const MOST: usize = 256;
/// Distance of a corner in front of a plane that counts as rounding, as a fraction of the part's
/// size.
const ROUNDING: f32 = 1e-5;

/// Returns the box of the closed convex part of each triangle, if it belongs to one.
pub(crate) fn boxes(geometry: &Geometry) -> Vec<Option<Aabb>> {
    let triangles = geometry.triangles();
    let corners = weld_vertices(geometry);
    let mut parents: Vec<u32> = (0..corners.len() as u32).collect();
    let of = |vertex: u32| corners[vertex as usize];
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let [a, b] = [a, other].map(|vertex| root(&mut parents, of(vertex)));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    let mut order: Vec<(u32, u32)> = (0_u32..)
        .zip(triangles)
        .map(|(id, &[a, _, _])| (root(&mut parents, of(a)), id))
        .collect();
    order.sort_unstable();
    let mut out = vec![None; triangles.len()];
    for part in order.chunk_by(|(a, _), (b, _)| a == b) {
        let ids = || part.iter().map(|&(_, id)| id);
        if part.len() <= MOST && is_closed(ids().map(|id| triangles[id as usize].map(of))) {
            let bounds = Aabb::from_points(ids().flat_map(|id| geometry.corners(id)));
            if is_convex(geometry, ids, bounds.diagonal()) {
                for id in ids() {
                    out[id as usize] = Some(bounds);
                }
            }
        }
    }
    out
}

/// Returns the first vertex at the position of each vertex. Meshes repeat vertices with different
/// normals.
fn weld_vertices(geometry: &Geometry) -> Vec<u32> {
    let mut known = HashMap::new();
    // Add zero, which turns -0 into 0.
    let bits = |place: &Vec3| (*place + Vec3::ZERO).to_array().map(f32::to_bits);
    (0_u32..)
        .zip(geometry.positions())
        .map(|(i, place)| *known.entry(bits(place)).or_insert(i))
        .collect()
}

/// Returns the root of a corner's part, and compresses the path to it.
fn root(parents: &mut [u32], mut corner: u32) -> u32 {
    while parents[corner as usize] != corner {
        let parent = parents[corner as usize];
        parents[corner as usize] = parents[parent as usize];
        corner = parent;
    }
    corner
}

/// Reports whether each edge occurs equally often in both directions.
fn is_closed(triangles: impl Iterator<Item = [u32; 3]>) -> bool {
    let mut edges: Vec<(u32, u32, i32)> = Vec::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let way = if from < to { 1 } else { -1 };
            edges.push((from.min(to), from.max(to), way));
        }
    }
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .all(|edge| edge.iter().map(|(_, _, way)| way).sum::<i32>() == 0)
}

/// Reports whether all corners are behind the planes of all triangles.
fn is_convex<I: Iterator<Item = u32>>(geometry: &Geometry, ids: impl Fn() -> I, size: f32) -> bool {
    ids().all(|id| {
        let [a, b, c] = geometry.corners(id);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let mut corners = ids().flat_map(|other| geometry.corners(other));
        corners.all(|corner| normal.dot(corner - a) <= ROUNDING * size)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scenes;

    /// Returns the number of an object's triangles in closed convex parts, and the number of all
    /// its triangles.
    fn count_convex(object: &str) -> (usize, usize) {
        let text = format!(
            "[[light]]\nkind = \"directional\"\ndirection = [1, -2, 0.5]\n[[object]]\n{object}"
        );
        let scene = scenes::parse(&text, "test.toml", ".").expect("a scene");
        let geometry = Geometry::bake(&scene).expect("a geometry");
        let boxes = boxes(&geometry);
        (boxes.iter().flatten().count(), boxes.len())
    }

    #[test]
    fn boxes_are_closed_and_planes_are_not() {
        assert_eq!(count_convex("shape = \"box\""), (12, 12));
        assert_eq!(
            count_convex("shape = \"box\"\nscale = [-1, 2, 3]\nrotate_degrees = [10, 20, 30]"),
            (12, 12)
        );
        let (closed, all) = count_convex("shape = \"plane\"");
        assert!(closed == 0 && all > 0, "{closed} of {all}");
    }

    #[test]
    fn a_town_is_made_of_boxes() {
        let scene = (scenes::find("town").expect("a scene").build)();
        let geometry = Geometry::bake(&scene).expect("a geometry");
        let boxes = boxes(&geometry);
        let share = boxes.iter().flatten().count() as f32 / boxes.len() as f32;
        assert!(share > 0.9, "{share}");
    }

    #[test]
    fn a_room_seen_from_inside_keeps_its_walls() {
        // Their triangles face inwards.
        for name in ["c3-room", "room-corner"] {
            let scene = (scenes::find(name).expect("a scene").build)();
            let geometry = Geometry::bake(&scene).expect("a geometry");
            let bounds = geometry.bounds();
            let whole = boxes(&geometry)
                .into_iter()
                .flatten()
                .any(|part| part.diagonal() > 0.95 * bounds.diagonal());
            assert!(!whole, "{name}");
        }
    }
}
