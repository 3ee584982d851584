//! A tree of boxes over facets in a frame along the light: an implicit eight-way tree over facets
//! in Morton order, large ones first.

use crate::{
    frame::{Frame, cross},
    morton,
};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

/// Children of a node, and lanes of its tests.
const CHILDREN: usize = 8;

/// A facet in a frame: corners as (x, y, height), counter-clockwise as the sun sees them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projected {
    pub(crate) corners: [DVec3; 3],
}

impl Projected {
    /// Returns twice the area across the light.
    #[inline(always)]
    pub(crate) fn twice_area(&self) -> f64 {
        let [a, b, c] = self.corners;
        cross((b - a).xy(), (c - a).xy())
    }
}

/// A box across the light and the greatest height inside, all as lower limits: least x and y, and
/// the negative greatest x, y and height.
pub(crate) type Limits = [f32; 5];

fn limits_of(corners: &[DVec3]) -> Limits {
    let low = corners.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = corners
        .iter()
        .fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    [low.x, low.y, -high.x, -high.y, -high.z].map(round_down)
}

/// Returns a query for facets that overlap these corners and reach above the least height, less the
/// margin.
pub(crate) fn query_above(corners: &[DVec3], margin: f64) -> Limits {
    let [x, y, end_x, end_y, _] = limits_of(corners);
    let least = corners
        .iter()
        .fold(f64::INFINITY, |least, p| least.min(p.z));
    [-end_x, -end_y, -x, -y, -round_down(least - margin)]
}

/// Returns a query for facets that overlap these corners, at any height.
pub(crate) fn query_all(corners: &[DVec3]) -> Limits {
    query_above(corners, f64::INFINITY)
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

/// Facets in a frame along the light, in the order of the tree.
pub(crate) struct Scene {
    pub(crate) facets: Vec<Projected>,
    /// The caller's row of each facet.
    pub(crate) rows: Vec<u32>,
    /// Nodes of each level, from the leaves' parents to the root.
    levels: Vec<Vec<Node>>,
}

impl Scene {
    /// Builds the tree over the facets (row, corners in the frame) that are seen by the sun.
    /// `corners` returns the corners of a row if it is seen; `rows` is the number of rows.
    pub(crate) fn new(
        rows: usize,
        corners: impl Fn(u32) -> Option<[DVec3; 3]> + Sync,
        bounds: [DVec2; 2],
    ) -> Self {
        let [low, high] = bounds;
        let extent = (high - low).max_element().max(f64::MIN_POSITIVE);
        let scale = morton::STEPS / extent;
        let key = |[a, b, c]: [DVec3; 3]| {
            let least = a.min(b).min(c).truncate();
            let most = a.max(b).max(c).truncate();
            let size = (most - least).max_element().max(f64::MIN_POSITIVE);
            // Nodes are tight if their facets are of similar size: within a factor of four.
            let class = ((extent / size).log2() / 2.0).clamp(0.0, 31.0) as u64;
            let centre = (least.midpoint(most) - low) * scale;
            class << 42 | morton::code_2d(centre.clamp(DVec2::ZERO, DVec2::splat(morton::STEPS)))
        };
        let mut keys: Vec<(u64, u32)> = (0..rows as u32)
            .into_par_iter()
            .filter_map(|row| corners(row).map(|corners| (key(corners), row)))
            .collect();
        keys.par_sort_unstable();
        let facets: Vec<Projected> = keys
            .par_iter()
            .map(|&(_, row)| Projected {
                corners: corners(row).unwrap_or_default(),
            })
            .collect();
        let leaves: Vec<Node> = facets
            .par_chunks(CHILDREN)
            .map(|group| Node::new(group.iter().map(|facet| limits_of(&facet.corners))))
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
            facets,
            rows: keys.par_iter().map(|&(_, row)| row).collect(),
            levels,
        }
    }

    /// Returns whether a facet overlaps a query.
    #[inline(always)]
    pub(crate) fn overlaps(&self, index: u32, query: &Limits) -> bool {
        let [node, child] = [index as usize / CHILDREN, index as usize % CHILDREN];
        let limits = &self.levels[0][node].0;
        limits
            .iter()
            .zip(query)
            .all(|(all, end)| all[child] <= *end)
    }

    /// Appends the indices of the facets that overlap a query, large ones first.
    pub(crate) fn overlapping(
        &self,
        query: &Limits,
        stack: &mut Vec<(u32, u32)>,
        out: &mut Vec<u32>,
    ) {
        stack.clear();
        if !self.facets.is_empty() {
            stack.push((self.levels.len() as u32 - 1, 0));
        }
        while let Some((level, node)) = stack.pop() {
            let mut bits = self.levels[level as usize][node as usize].overlapping(query);
            let first = node * CHILDREN as u32;
            if level == 0 {
                while bits != 0 {
                    out.push(first + bits.trailing_zeros());
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
    }
}

/// Returns a box across the light around a box in space.
pub(crate) fn bounds_across(frame: &Frame, bounds: [DVec3; 2]) -> [DVec2; 2] {
    let [low, high] = bounds;
    let corners = (0..8).map(|i| {
        let pick = |bit: u32, axis: usize| {
            if i >> bit & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            }
        };
        frame.across(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
    });
    corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
        [low.min(p), high.max(p)]
    })
}
