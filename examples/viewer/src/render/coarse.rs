//! Levels of detail for images of few pixels: vertices less than about a pixel apart are merged.
//!
//! On software drivers each triangle costs more than the pixels that it covers. Vertices are merged
//! by the cells of a grid (Rossignac and Borrel 1993, "Multi-resolution 3D approximations for
//! rendering complex scenes"). One of the vertices of a cell replaces all of them, so that flat
//! surfaces stay flat. Corners of long triangles don't move: otherwise whole walls would tilt and
//! shadow themselves.

use std::{
    collections::{HashMap, HashSet},
    ops::Range,
};
use umbrage::{
    Geometry,
    glam::{IVec3, Vec3},
};

/// Sides of the grids' cells, as fractions of the scene's diagonal, the finest first.
const CELLS: [f32; 5] = [
    1.0 / 16384.0,
    1.0 / 8192.0,
    1.0 / 4096.0,
    1.0 / 2048.0,
    1.0 / 1024.0,
];
/// Greatest ratio of triangles to the previous level for which a level is kept.
const WORTH: f32 = 0.8;
/// Triangles with an edge longer than this, in cells, keep their corners.
const LONG: f32 = 4.0;
/// Greatest side of a cell, pixels.
const MOST_PIXELS: f32 = 1.0;

/// A list of fewer triangles.
pub(super) struct CoarseLevel {
    /// Side of its cells, metres.
    cell: f32,
    pub indices: Range<u32>,
}

/// Appends the triangles of coarser levels to a list of triangles, and returns the levels of each
/// run. Runs are ranges of indices, three for each triangle.
pub(super) fn add_levels(
    geometry: &Geometry,
    triangles: &mut Vec<[u32; 3]>,
    runs: &[Range<u32>],
) -> Vec<Vec<CoarseLevel>> {
    let diagonal = geometry.bounds().diagonal();
    let mut levels: Vec<Vec<CoarseLevel>> = runs.iter().map(|_| Vec::new()).collect();
    let mut least: Vec<usize> = runs.iter().map(|run| run.len() / 3).collect();
    for share in CELLS {
        let cell = share * diagonal;
        let stands_for = merge_vertices(geometry, cell);
        for (i, run) in runs.iter().enumerate() {
            let own = run.start as usize / 3..run.end as usize / 3;
            let fewer = fewer(&triangles[own], &stands_for);
            if fewer.len() as f32 > WORTH * least[i] as f32 {
                continue;
            }
            least[i] = fewer.len();
            let begin = 3 * triangles.len() as u32;
            triangles.extend(fewer);
            levels[i].push(CoarseLevel {
                cell,
                indices: begin..3 * triangles.len() as u32,
            });
        }
    }
    levels
}

/// Returns the coarsest level whose cells are small enough for pixels of this width, metres.
pub(super) fn level_for(levels: &[CoarseLevel], pixel: f32) -> Option<&CoarseLevel> {
    let is_fine = |level: &&CoarseLevel| level.cell <= MOST_PIXELS * pixel;
    levels.iter().rev().find(is_fine)
}

/// Returns the replacement of each vertex.
fn merge_vertices(geometry: &Geometry, cell: f32) -> Vec<u32> {
    let positions = geometry.positions();
    let normals = geometry.normals();
    let mut stays = vec![false; positions.len()];
    for corners in geometry.triangles() {
        let [a, b, c] = corners.map(|corner| positions[corner as usize]);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        if longest > LONG * cell {
            for corner in corners {
                stays[*corner as usize] = true;
            }
        }
    }
    let mut first: HashMap<(IVec3, u8), u32> = HashMap::new();
    let stands_for = |(i, place): (u32, &Vec3)| {
        if stays[i as usize] {
            return i;
        }
        let side = normals.get(i as usize).map_or(0, |normal| side_of(*normal));
        let key = ((*place / cell).floor().as_ivec3(), side);
        *first.entry(key).or_insert(i)
    };
    (0..).zip(positions).map(stands_for).collect()
}

/// Returns the side of a cube in the direction of a normal. Surfaces of different sides keep their
/// shading.
fn side_of(normal: Vec3) -> u8 {
    let along = normal.abs();
    let axis = if along.x >= along.y.max(along.z) {
        0
    } else if along.y >= along.z {
        1
    } else {
        2
    };
    2 * axis + u8::from(normal[usize::from(axis)] < 0.0)
}

/// Returns the remaining distinct triangles with three corners.
fn fewer(triangles: &[[u32; 3]], stands_for: &[u32]) -> Vec<[u32; 3]> {
    let mut known = HashSet::new();
    let mut out = Vec::new();
    for corners in triangles {
        let mut corners = corners.map(|corner| stands_for[corner as usize]);
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            continue;
        }
        // Normalise the order of corners: cyclic rotations are the same triangle.
        let turns = match corners {
            [a, b, c] if a < b.min(c) => 0,
            [_, b, c] if b < c => 1,
            _ => 2,
        };
        corners.rotate_left(turns);
        if known.insert(corners) {
            out.push(corners);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scenes;

    fn geometry(text: &str) -> Geometry {
        let head = "[[light]]\nkind = \"directional\"\ndirection = [1, -2, 0.5]\n[[object]]\n";
        let scene = scenes::parse(&format!("{head}{text}"), "test.toml", ".").expect("a scene");
        Geometry::bake(&scene).expect("a geometry")
    }

    #[test]
    fn small_triangles_merge_and_long_ones_stay() {
        let ball = geometry("shape = \"sphere\"");
        let all = ball.triangles().len();
        let count = |cell: f32| fewer(ball.triangles(), &merge_vertices(&ball, cell)).len();
        let (fine, coarse) = (count(1e-4), count(0.3));
        assert!(fine > all / 2, "{fine} of {all}");
        assert!(coarse < all / 4 && coarse > 8, "{coarse} of {all}");
        let plane = geometry("shape = \"plane\"");
        let stands_for = merge_vertices(&plane, 0.5);
        assert!((0..).zip(&stands_for).all(|(i, other)| i == *other));
    }

    #[test]
    fn levels_get_coarser_and_move_nothing_far() {
        let scene = (scenes::find("street").expect("built in").build)();
        let geometry = Geometry::bake(&scene).expect("a geometry");
        let mut triangles = geometry.triangles().to_vec();
        let all = 3 * triangles.len() as u32;
        let levels = add_levels(&geometry, &mut triangles, std::slice::from_ref(&(0..all)));
        let counts: Vec<usize> = levels[0].iter().map(|level| level.indices.len()).collect();
        assert!(!counts.is_empty() && counts[0] < all as usize, "{counts:?}");
        assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
        for cell in [0.05, 0.5] {
            let stands_for = merge_vertices(&geometry, cell);
            let far = geometry.positions().iter().zip(&stands_for);
            let most = far
                .map(|(place, other)| place.distance(geometry.positions()[*other as usize]))
                .fold(0.0, f32::max);
            assert!(most <= 1.8 * cell, "{most} of {cell}");
        }
        let fits = |pixel: f32| level_for(&levels[0], pixel).map(|level| level.cell);
        assert_eq!(fits(0.0), None);
        assert_eq!(
            fits(f32::INFINITY),
            levels[0].last().map(|level| level.cell)
        );
    }
}
