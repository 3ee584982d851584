//! Seams where triangles meet without sharing their corners: an edge on one side, several on the other (T-junctions).
//!
//! Shadow volumes would put walls on both sides there, which cancel but for rounding. Splitting the triangles at the
//! corners that lie on their edges makes both sides share them, and then there is no wall.

use crate::techniques::volumes::silhouette::{Cap, net_edges};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// A corner lies on an edge if it is within this fraction of the greatest coordinate of it: 2^-21, 8 units in the last
/// place at most, what placing an instance rounds.
const ON_EDGE: f64 = 1.0 / 2_097_152.0;

/// Points on edges, in the order from the lower to the higher end.
type OnEdge = HashMap<[u32; 2], Vec<u32>>;

/// The same triangles, split where a seam's corners lie on an edge.
pub(crate) fn split_at_t_junctions(positions: &[Vec3], caps: Vec<Cap>) -> Vec<Cap> {
    let on_edge = find_on_edges(positions, &net_edges(caps.iter().map(|cap| cap.corners)));
    if on_edge.is_empty() {
        return caps;
    }
    let mut out = Vec::with_capacity(caps.len());
    for cap in caps {
        let [a, b, c] = cap.corners;
        let sides = [[a, b], [b, c], [c, a]].map(|edge| points_along(&on_edge, edge));
        if sides.iter().all(Vec::is_empty) {
            out.push(cap);
        } else {
            split(cap.corners, &sides, &mut out);
        }
    }
    out
}

fn points_along(on_edge: &OnEdge, [from, to]: [u32; 2]) -> Vec<u32> {
    let mut points = on_edge
        .get(&[from.min(to), from.max(to)])
        .cloned()
        .unwrap_or_default();
    if from > to {
        points.reverse();
    }
    points
}

/// Splits a triangle with these points along its three sides: off the middle one of a side, towards the opposite
/// corner.
fn split([a, b, c]: [u32; 3], sides: &[Vec<u32>; 3], out: &mut Vec<Cap>) {
    let [ab, bc, ca] = sides;
    if ab.is_empty() {
        if bc.is_empty() && ca.is_empty() {
            return out.push(Cap {
                corners: [a, b, c],
                in_scene: false,
            });
        }
        return split([b, c, a], &[bc.clone(), ca.clone(), Vec::new()], out);
    }
    let middle = ab.len() / 2;
    let p = ab[middle];
    split(
        [a, p, c],
        &[ab[..middle].to_vec(), Vec::new(), ca.clone()],
        out,
    );
    split(
        [p, b, c],
        &[ab[middle + 1..].to_vec(), bc.clone(), Vec::new()],
        out,
    );
}

/// Finds the ends of edges that lie inside other edges.
fn find_on_edges(positions: &[Vec3], edges: &[([u32; 2], u32)]) -> OnEdge {
    let mut ends: Vec<u32> = edges.iter().flat_map(|e| e.0).collect();
    ends.sort_unstable();
    ends.dedup();
    let grid = Grid::new(positions, edges, &ends);
    let mut out = OnEdge::new();
    for &([from, to], _) in edges {
        let key = [from.min(to), from.max(to)];
        let points = grid.on_edge(key);
        if !points.is_empty() {
            out.insert(key, points);
        }
    }
    out
}

/// Points in cubes as wide as an edge is long on average, so that all edges together pass few of them.
struct Grid<'a> {
    positions: &'a [Vec3],
    cell: f64,
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> Grid<'a> {
    fn new(positions: &'a [Vec3], edges: &[([u32; 2], u32)], points: &[u32]) -> Self {
        let at = |v: u32| positions[v as usize].as_dvec3();
        let total: f64 = edges.iter().map(|&([a, b], _)| at(a).distance(at(b))).sum();
        let reach = points
            .iter()
            .map(|&v| at(v).abs().max_element())
            .fold(0.0, f64::max);
        // The bound keeps cells' numbers far below 2^63.
        let cell = (total / edges.len().max(1) as f64)
            .max(reach * ON_EDGE)
            .max(f64::MIN_POSITIVE);
        let mut out = Self {
            positions,
            cell,
            tolerance: reach * ON_EDGE,
            cells: HashMap::new(),
        };
        for &point in points {
            out.cells
                .entry(out.cell_of(at(point)))
                .or_default()
                .push(point);
        }
        out
    }

    fn cell_of(&self, p: DVec3) -> [i64; 3] {
        (p / self.cell).floor().to_array().map(|x| x as i64)
    }

    /// The points inside an edge, from its first end on.
    fn on_edge(&self, [from, to]: [u32; 2]) -> Vec<u32> {
        let [a, b] = [from, to].map(|v| self.positions[v as usize].as_dvec3());
        let pieces = ((b - a).length() / self.cell).ceil().max(1.0) as usize;
        let mut found = Vec::new();
        for i in 0..pieces {
            let [p, q] = [i, i + 1].map(|k| a.lerp(b, k as f64 / pieces as f64));
            self.near_piece(p, q, &mut found);
        }
        let mut found: Vec<(f64, u32)> = found
            .into_iter()
            .filter_map(|v| Some((self.along(a, b, v)?, v)))
            .collect();
        found.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        found.dedup();
        found.into_iter().map(|(_, v)| v).collect()
    }

    fn near_piece(&self, p: DVec3, q: DVec3, found: &mut Vec<u32>) {
        let [low, high] = [
            self.cell_of(p.min(q) - self.tolerance),
            self.cell_of(p.max(q) + self.tolerance),
        ];
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    found.extend(self.cells.get(&[x, y, z]).into_iter().flatten());
                }
            }
        }
    }

    /// How far along the edge a point lies, 0 to 1 without both; none if it does not lie on it.
    fn along(&self, a: DVec3, b: DVec3, point: u32) -> Option<f64> {
        let p = self.positions[point as usize].as_dvec3();
        let t = (p - a).dot(b - a) / (b - a).length_squared();
        let inside = t > 0.0 && t < 1.0 && p != a && p != b;
        (inside && p.distance(a.lerp(b, t)) <= self.tolerance).then_some(t)
    }
}
