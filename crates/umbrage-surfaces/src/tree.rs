//! A tree of boxes over facets in a frame along the light: an implicit eight-way tree over facets
//! in Morton order, wide ones first.

use crate::grid::{Grid, Rectangle, Tile};
use glam::{BVec3, DMat3, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

/// Children of a node, and lanes of its tests.
const CHILDREN: usize = 8;

/// A facet in a frame: corners as (x, y, height), counter-clockwise as the sun sees them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Projected {
    pub(crate) corners: [DVec3; 3],
}

impl Projected {
    /// Returns twice the area across the light.
    #[inline(always)]
    pub(crate) fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).xy().perp_dot((c - a).xy())
    }

    /// Returns the height of the facet's plane at a step across the light from the first corner.
    #[inline(always)]
    pub(crate) fn height_at(&self, step: DVec2) -> f64 {
        let [a, b, c] = self.corners;
        let [p, q] = [b - a, c - a].map(|side| side.xy());
        let weights = [step.perp_dot(q), p.perp_dot(step)].map(|area| area / self.twice_area());
        a.z + (b.z - a.z) * weights[0] + (c.z - a.z) * weights[1]
    }

    /// Returns the mean height of the corners.
    pub(crate) fn mean_height(&self) -> f64 {
        let [a, b, c] = self.corners;
        (a.z + b.z + c.z) / 3.0
    }

    /// Returns the box across the light.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> Rectangle {
        let [a, b, c] = self.corners;
        [a.min(b).min(c).xy(), a.max(b).max(c).xy()]
    }
}

/// Memory of a search: levels and nodes.
pub(crate) type Stack = Vec<(u32, u32)>;

/// A box across the light and the greatest height inside, all as lower limits: least x and y, and
/// the negative greatest x, y and height.
pub(crate) type Limits = [f32; 5];

fn limits_of(facet: &Projected) -> Limits {
    let [low, high] = box_around(facet.corners.into_iter());
    [low.x, low.y, -high.x, -high.y, -high.z].map(round_down)
}

fn box_around(corners: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    corners.fold(empty, |[low, high], p| [low.min(p), high.max(p)])
}

/// Returns a query for facets that overlap these corners and reach above the least height, less the
/// margin.
pub(crate) fn query_above(corners: impl Iterator<Item = DVec3>, margin: f64) -> Limits {
    let [low, high] = box_around(corners);
    let limits = [-high.x, -high.y, low.x, low.y, low.z - margin];
    limits.map(|limit| -round_down(limit))
}

/// Returns a query for facets that overlap these corners, at any height.
pub(crate) fn query_all(corners: [DVec3; 2]) -> Limits {
    query_above(corners.into_iter(), f64::INFINITY)
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x {
        rounded.next_down()
    } else {
        rounded
    }
}

/// Limits of the children of a node; infinity for unused ones, which overlap nothing.
#[derive(Clone, Copy, Debug)]
struct Node([[f32; CHILDREN]; 5]);

impl Node {
    fn new(children: impl Iterator<Item = Limits>) -> Self {
        let mut node = Self([[f32::INFINITY; CHILDREN]; 5]);
        for (i, child) in children.enumerate() {
            for (all, limit) in node.0.iter_mut().zip(child) {
                all[i] = limit;
            }
        }
        node
    }

    fn limits(&self) -> Limits {
        self.0
            .map(|all| all.into_iter().fold(f32::INFINITY, f32::min))
    }

    /// Returns a bit for each child that overlaps the query: all limits are below its numbers.
    #[inline(always)]
    fn overlapping(&self, query: &Limits) -> u32 {
        let mut bits = 0;
        for i in 0..CHILDREN {
            let mut overlaps = true;
            for (all, end) in self.0.iter().zip(query) {
                overlaps &= all[i] <= *end;
            }
            bits |= u32::from(overlaps) << i;
        }
        bits
    }
}

/// The facets of a tile ([`Grid::is_in_tile`]), in the order of the tree: wide ones first.
pub(crate) struct Scene<'a> {
    grid: &'a Grid,
    pub(crate) facets: Vec<Projected>,
    /// The caller's rows of the facets.
    rows: Vec<u32>,
    /// Number of facets that are computed cell by cell.
    wide: u32,
    tile: &'a Tile,
    /// Cells of the tile, and the facets that are computed in them, but for wide ones: rising.
    receivers: Vec<(u32, u32)>,
    /// Nodes of each level, from the leaves' parents to the root.
    levels: Vec<Vec<Node>>,
}

impl<'a> Scene<'a> {
    /// Builds the tree over the facets of a tile. `seen` returns one of `rows` facets
    /// as the sun sees it.
    pub(crate) fn new(
        grid: &'a Grid,
        tile: &'a Tile,
        rows: u32,
        seen: &(impl Fn(u32) -> Option<Projected> + Sync),
    ) -> Self {
        let key_of = |row: u32| {
            let facet = seen(row).filter(|facet| grid.is_in_tile(facet, tile))?;
            let (key, cell) = grid.key(&facet);
            Some((key, row, cell))
        };
        let mut sorted: Vec<(u64, u32, u32)> =
            (0..rows).into_par_iter().filter_map(key_of).collect();
        sorted.par_sort_unstable();
        let rows: Vec<u32> = sorted.par_iter().map(|&(_, row, _)| row).collect();
        let facets: Vec<Projected> = rows
            .par_iter()
            .map(|&row| seen(row).unwrap_or_default())
            .collect();
        let wide = sorted.partition_point(|&(key, ..)| !Grid::is_narrow(key)) as u32;
        let mut receivers: Vec<(u32, u32)> = (wide..sorted.len() as u32)
            .into_par_iter()
            .map(|index| (sorted[index as usize].2, index))
            .filter(|(cell, _)| tile.cells.contains(cell))
            .collect();
        receivers.par_sort_unstable();
        let leaves: Vec<Node> = facets
            .par_chunks(CHILDREN)
            .map(|group| Node::new(group.iter().map(limits_of)))
            .collect();
        let mut levels = vec![leaves];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let level = below
                .par_chunks(CHILDREN)
                .map(|group| Node::new(group.iter().map(Node::limits)))
                .collect();
            levels.push(level);
        }
        Self {
            grid,
            facets,
            rows,
            wide,
            tile,
            receivers,
            levels,
        }
    }

    /// Returns the caller's row of a facet.
    #[inline(always)]
    pub(crate) fn row(&self, index: u32) -> u32 {
        self.rows[index as usize]
    }

    /// Returns whether a facet is computed as a whole.
    pub(crate) fn is_narrow(&self, index: u32) -> bool {
        index >= self.wide
    }

    /// Returns the rectangle of a cell.
    pub(crate) fn rectangle(&self, cell: u32) -> Rectangle {
        self.grid.rectangle(cell)
    }

    /// Computes a value for each cell of the tile, in order, with memory that is reused.
    pub(crate) fn map_cells<M: Default + Send, T: Send>(
        &self,
        compute: impl Fn(&mut M, u32) -> T + Send + Sync,
    ) -> Vec<T> {
        let cells = self.tile.cells.clone().into_par_iter();
        cells.map_init(M::default, compute).collect()
    }

    /// Returns the facets that are computed as a whole in a cell, rising.
    pub(crate) fn narrow_facets(&self, cell: u32) -> impl Iterator<Item = u32> {
        let start = self.receivers.partition_point(|&(other, _)| other < cell);
        let in_cell = self.receivers[start..].iter().copied();
        in_cell
            .take_while(move |&(other, _)| other == cell)
            .map(|(_, index)| index)
    }

    /// Returns the facets that are computed within the rectangle of a cell, rising.
    pub(crate) fn wide_facets(&self, rectangle: Rectangle, stack: &mut Stack) -> Vec<u32> {
        let query = query_all(rectangle.map(|p| p.extend(0.0)));
        let mut wide = Vec::new();
        self.visit_overlapping(&query, stack, |index| {
            // Wide ones are first.
            let is_narrow = self.is_narrow(index);
            wide.extend((!is_narrow).then_some(index));
            is_narrow
        });
        wide
    }

    /// Passes the facets that overlap a query to `visit`, wide ones first, until it returns true.
    /// Returns whether it did.
    #[inline(always)]
    pub(crate) fn visit_overlapping(
        &self,
        query: &Limits,
        stack: &mut Stack,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        stack.clear();
        if !self.facets.is_empty() {
            stack.push((self.levels.len() as u32 - 1, 0));
        }
        while let Some((level, node)) = stack.pop() {
            let mut bits = self.levels[level as usize][node as usize].overlapping(query);
            let first = node * CHILDREN as u32;
            if level == 0 {
                while bits != 0 {
                    if visit(first + bits.trailing_zeros()) {
                        return true;
                    }
                    bits &= bits - 1;
                }
                continue;
            }
            // Push in reverse, as the last one is visited first.
            while bits != 0 {
                let child = 31 - bits.leading_zeros();
                stack.push((level - 1, first + child));
                bits ^= 1 << child;
            }
        }
        false
    }
}

/// Returns a box across the light around a box in space.
pub(crate) fn bounds_across(frame: &DMat3, bounds: [DVec3; 2]) -> Rectangle {
    let [low, high] = bounds;
    let corners = (0..8).map(|i| {
        let is_high = BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
        let corner = DVec3::select(is_high, high, low);
        frame.transpose_mul_vec3(corner).xy()
    });
    corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
        [low.min(p), high.max(p)]
    })
}
