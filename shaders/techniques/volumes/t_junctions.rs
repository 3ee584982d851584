//! T-junctions: seams where triangles meet without sharing their corners, with one edge on one side
//! and several on the other.
//!
//! Shadow volumes would have walls on both sides there, which cancel except for rounding. Splitting
//! the triangles at the corners on their edges makes both sides share them, and removes the walls.

use crate::techniques::volumes::silhouette::{Cap, NetEdge, net_edges};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Tolerance of edges: a corner is on an edge if it is within this fraction of the greatest
/// coordinate of it. 2^-21 is at most 8 units in the last place, the rounding of an instance
/// transform.
const ON_EDGE: f64 = 1.0 / 2_097_152.0;

/// Points inside edges. Keys are an edge's two ends, the lower first. Points are in the order from
/// the lower end to the higher one.
type PointsOnEdges = HashMap<[u32; 2], Vec<u32>>;

/// Returns the triangles, split where a seam's corners are on an edge.
pub(crate) fn split_at_t_junctions(positions: &[Vec3], caps: Vec<Cap>) -> Vec<Cap> {
    let seams = net_edges(caps.iter().map(|cap| cap.corners));
    let on_edges = find_points_on_edges(positions, &seams);
    if on_edges.is_empty() {
        return caps;
    }
    let mut out = Vec::with_capacity(caps.len());
    for cap in caps {
        let [a, b, c] = cap.corners;
        let sides = [
            points_along(&on_edges, a, b),
            points_along(&on_edges, b, c),
            points_along(&on_edges, c, a),
        ];
        if sides.iter().all(Vec::is_empty) {
            out.push(cap);
        } else {
            split(a, b, c, &sides, &mut out);
        }
    }
    out
}

/// Returns the points inside an edge, in the order from `from` to `to`.
fn points_along(on_edges: &PointsOnEdges, from: u32, to: u32) -> Vec<u32> {
    let mut points = on_edges
        .get(&[from.min(to), from.max(to)])
        .cloned()
        .unwrap_or_default();
    if from > to {
        points.reverse();
    }
    points
}

/// Splits the triangle (a, b, c) with these points along its sides ab, bc and ca. It is cut from
/// the middle point of a side to the opposite corner, and each half recursively.
fn split(a: u32, b: u32, c: u32, sides: &[Vec<u32>; 3], out: &mut Vec<Cap>) {
    let [ab, bc, ca] = sides;
    if ab.is_empty() {
        if bc.is_empty() && ca.is_empty() {
            return out.push(Cap {
                corners: [a, b, c],
                in_scene: false,
            });
        }
        // Rotate the triangle until its first side has points.
        return split(b, c, a, &[bc.clone(), ca.clone(), Vec::new()], out);
    }
    let middle = ab.len() / 2;
    let p = ab[middle];
    let before = ab[..middle].to_vec();
    let after = ab[middle + 1..].to_vec();
    split(a, p, c, &[before, Vec::new(), ca.clone()], out);
    split(p, b, c, &[after, bc.clone(), Vec::new()], out);
}

/// Finds the ends of edges that are inside other edges.
fn find_points_on_edges(positions: &[Vec3], edges: &[NetEdge]) -> PointsOnEdges {
    let mut ends: Vec<u32> = edges.iter().flat_map(|e| [e.from, e.to]).collect();
    ends.sort_unstable();
    ends.dedup();
    let grid = Grid::new(positions, edges, &ends);
    let mut out = PointsOnEdges::new();
    for edge in edges {
        let low = edge.from.min(edge.to);
        let high = edge.from.max(edge.to);
        let points = grid.points_inside(low, high);
        if !points.is_empty() {
            out.insert([low, high], points);
        }
    }
    out
}

/// Points in cubes whose side is the mean length of edges, so that all edges together pass few
/// cubes.
struct Grid<'a> {
    positions: &'a [Vec3],
    /// Side of a cube, metres.
    cell: f64,
    /// Greatest distance of an edge's points from it, metres.
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> Grid<'a> {
    fn new(positions: &'a [Vec3], edges: &[NetEdge], points: &[u32]) -> Self {
        let position = |v: u32| positions[v as usize].as_dvec3();
        let total_length: f64 = edges
            .iter()
            .map(|edge| position(edge.from).distance(position(edge.to)))
            .sum();
        let reach = points
            .iter()
            .map(|&v| position(v).abs().max_element())
            .fold(0.0, f64::max);
        // The bound keeps cell indices far below 2^63.
        let cell = (total_length / edges.len().max(1) as f64)
            .max(reach * ON_EDGE)
            .max(f64::MIN_POSITIVE);
        let mut out = Self {
            positions,
            cell,
            tolerance: reach * ON_EDGE,
            cells: HashMap::new(),
        };
        for &point in points {
            let key = out.cell_of(position(point));
            out.cells.entry(key).or_default().push(point);
        }
        out
    }

    fn cell_of(&self, p: DVec3) -> [i64; 3] {
        (p / self.cell).floor().to_array().map(|x| x as i64)
    }

    /// Returns the points inside an edge, in the order from `from` to `to`.
    fn points_inside(&self, from: u32, to: u32) -> Vec<u32> {
        let a = self.positions[from as usize].as_dvec3();
        let b = self.positions[to as usize].as_dvec3();
        // Split into pieces no longer than a cell, since the box of a long slanted edge contains
        // many cells that it does not pass.
        let pieces = ((b - a).length() / self.cell).ceil().max(1.0) as usize;
        let mut candidates = Vec::new();
        for i in 0..pieces {
            let p = a.lerp(b, i as f64 / pieces as f64);
            let q = a.lerp(b, (i + 1) as f64 / pieces as f64);
            self.add_near_piece(p, q, &mut candidates);
        }
        let mut found: Vec<(f64, u32)> = candidates
            .into_iter()
            .filter_map(|v| Some((self.parameter_along(a, b, v)?, v)))
            .collect();
        found.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        // Neighbouring pieces share cells.
        found.dedup();
        found.into_iter().map(|(_, v)| v).collect()
    }

    /// Adds the points in the box around the piece of an edge from `p` to `q`.
    fn add_near_piece(&self, p: DVec3, q: DVec3, found: &mut Vec<u32>) {
        let min = p.min(q) - self.tolerance;
        let max = p.max(q) + self.tolerance;
        let low = self.cell_of(min);
        let high = self.cell_of(max);
        // If small triangles are next to large ones, a cell contains many points, but few are in
        // the box.
        let is_inside = |&v: &u32| {
            let point = self.positions[v as usize].as_dvec3();
            point.cmpge(min).all() && point.cmple(max).all()
        };
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let in_cell = self.cells.get(&[x, y, z]).into_iter().flatten().copied();
                    found.extend(in_cell.filter(is_inside));
                }
            }
        }
    }

    /// Returns the position of a point along the edge from `a` to `b`, between 0 and 1; `None` if
    /// it is not inside the edge.
    fn parameter_along(&self, a: DVec3, b: DVec3, point: u32) -> Option<f64> {
        let p = self.positions[point as usize].as_dvec3();
        let t = (p - a).dot(b - a) / (b - a).length_squared();
        let inside = t > 0.0 && t < 1.0 && p != a && p != b;
        (inside && p.distance(a.lerp(b, t)) <= self.tolerance).then_some(t)
    }
}
