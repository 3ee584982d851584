//! Tree of boxes over a list: boxes around runs of entries, around groups of these boxes, and so on
//! up to one box. Searches skip whole groups.
//!
//! Runs follow the order of the list, which is spatially coherent in meshes. The tree is therefore
//! built in one pass.

use crate::geometry::{Geometry, aabb::Aabb};
use crate::parallel::prelude::*;
#[cfg(feature = "testing")]
use std::sync::atomic::{self, AtomicU64};
use std::{cmp::Ordering, collections::BinaryHeap, ops::Range};

/// Entries per run. Fewer entries mean more boxes to test; more entries mean looser boxes.
pub(crate) const RUN: u32 = 64;
/// Boxes per group.
const GROUP: usize = 8;

/// The boxes, level by level.
#[derive(Debug)]
pub(crate) struct BoxTree {
    /// The boxes of the runs come first; each box of the next level holds [`GROUP`] boxes of the
    /// level before. The last level has one box. An empty list has a single empty level.
    levels: Vec<Vec<Aabb>>,
    /// See [`BoxTree::count`].
    #[cfg(feature = "testing")]
    counted: AtomicU64,
}

/// A box of the tree.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    node: Node,
    pub(crate) bounds: Aabb,
    /// Entries of the list, if this is the box of a run. At the ends of the walked range, the box
    /// may be larger than they need.
    pub(crate) run: Option<Range<u32>>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    level: usize,
    index: usize,
}

impl BoxTree {
    /// Builds the tree over these boxes of runs.
    pub(crate) fn new(runs: Vec<Aabb>) -> Self {
        let mut levels = vec![runs];
        while let Some(below) = levels.last()
            && below.len() > 1
        {
            let groups = below.chunks(GROUP);
            let around = |group: &[Aabb]| group.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
            let above = groups.map(around).collect();
            levels.push(above);
        }
        Self {
            levels,
            #[cfg(feature = "testing")]
            counted: AtomicU64::new(0),
        }
    }

    /// Builds the tree over a geometry's triangles.
    pub(crate) fn of_triangles(geometry: &Geometry) -> Self {
        let count = geometry.triangles().len() as u32;
        let box_of = |run: u32| {
            let first = run * RUN;
            Aabb::from_points(geometry.vertices_of(first..(first + RUN).min(count)))
        };
        let runs = (0..count.div_ceil(RUN)).into_par_iter().map(box_of);
        Self::new(runs.collect())
    }

    /// Returns the boxes of the runs.
    pub(crate) fn runs(&self) -> &[Aabb] {
        &self.levels[0]
    }

    /// Counts entries that were tested one by one, for tests.
    pub(crate) fn count(&self, entries: &Range<u32>) {
        #[cfg(feature = "testing")]
        self.counted
            .fetch_add(entries.len() as u64, atomic::Ordering::Relaxed);
        #[cfg(not(feature = "testing"))]
        let _ = entries;
    }

    /// Returns the number of entries tested one by one so far.
    #[cfg(feature = "testing")]
    pub(crate) fn box_count(&self) -> u64 {
        self.counted.load(atomic::Ordering::Relaxed)
    }

    /// Returns the box around the runs that contain entries of a range.
    pub(crate) fn enclosing_box(&self, entries: Range<u32>) -> Aabb {
        let mut all = Aabb::EMPTY;
        let mut walk = self.walk(entries.clone());
        while let Some(block) = walk.next() {
            let entries_of_block = self.entries(block.node);
            let is_whole = u64::from(entries.start) <= entries_of_block.start
                && entries_of_block.end <= u64::from(entries.end);
            if is_whole || block.run.is_some() {
                all = all.union(&block.bounds);
            } else {
                walk.enter(&block);
            }
        }
        all
    }

    /// Returns a walk over the boxes that contain entries of a range, in the order of the list.
    pub(crate) fn walk(&self, entries: Range<u32>) -> BoxWalk<'_> {
        let mut walk = BoxWalk {
            tree: self,
            entries,
            open: Vec::new(),
        };
        walk.open.extend(walk.tree.root(&walk.entries));
        walk
    }

    /// Returns the least value among the runs of a range; infinity if there is none. `least_in`
    /// computes a run's value from its entries and its box. `bound` returns a lower bound for all
    /// runs in a box.
    ///
    /// Boxes are visited in the order of their bounds, so that few runs are evaluated.
    pub(crate) fn least(
        &self,
        entries: Range<u32>,
        bound: impl Fn(&Aabb) -> f64,
        mut least_in: impl FnMut(Range<u32>, &Aabb) -> f64,
    ) -> f64 {
        let mut least = f64::INFINITY;
        let mut open = BinaryHeap::new();
        open.extend(self.root(&entries).map(|node| NearCandidate {
            bound: bound(&self.bounds(node)),
            node,
        }));
        while let Some(NearCandidate { bound: below, node }) = open.pop() {
            if below >= least {
                break;
            }
            if node.level == 0 {
                let run = self.run(node, &entries);
                least = least.min(least_in(run, &self.bounds(node)));
                continue;
            }
            for child in self.children(node, &entries) {
                let bound = bound(&self.bounds(child));
                if bound < least {
                    open.push(NearCandidate { bound, node: child });
                }
            }
        }
        least
    }

    /// Returns the topmost box; `None` if it contains no entry of the range.
    fn root(&self, entries: &Range<u32>) -> Option<Node> {
        let level = self.levels.len() - 1;
        let root = Node { level, index: 0 };
        (!self.levels[level].is_empty() && self.meets(root, entries)).then_some(root)
    }

    fn bounds(&self, node: Node) -> Aabb {
        self.levels[node.level][node.index]
    }

    /// Returns the boxes of a group that contain entries of a range, in order.
    fn children(&self, group: Node, entries: &Range<u32>) -> impl Iterator<Item = Node> {
        let level = group.level - 1;
        let first = group.index * GROUP;
        let end = (first + GROUP).min(self.levels[level].len());
        (first..end)
            .map(move |index| Node { level, index })
            .filter(|&node| self.meets(node, entries))
    }

    /// Returns the entries of a box, assuming that the list fills it.
    fn entries(&self, node: Node) -> Range<u64> {
        let length = u64::from(RUN) * (GROUP as u64).pow(node.level as u32);
        let first = node.index as u64 * length;
        first..first + length
    }

    fn meets(&self, node: Node, entries: &Range<u32>) -> bool {
        let of_node = self.entries(node);
        of_node.start < u64::from(entries.end) && u64::from(entries.start) < of_node.end
    }

    /// Returns the entries of a range that are in a run.
    fn run(&self, node: Node, entries: &Range<u32>) -> Range<u32> {
        let first = node.index as u32 * RUN;
        let end = first.saturating_add(RUN);
        first.max(entries.start)..end.min(entries.end)
    }
}

/// A walk over the tree, which descends only into groups that the caller enters.
#[derive(Clone, Debug)]
pub(crate) struct BoxWalk<'a> {
    tree: &'a BoxTree,
    entries: Range<u32>,
    /// The boxes still to visit, the next one last.
    open: Vec<Node>,
}

impl BoxWalk<'_> {
    /// Returns the next box.
    pub(crate) fn next(&mut self) -> Option<Block> {
        let node = self.open.pop()?;
        let is_run = node.level == 0;
        Some(Block {
            node,
            bounds: self.tree.bounds(node),
            run: is_run.then(|| self.tree.run(node, &self.entries)),
        })
    }

    /// Visits the boxes of a group next.
    ///
    /// Panics if the block is the box of a run.
    pub(crate) fn enter(&mut self, group: &Block) {
        let first_child = self.open.len();
        let children = self.tree.children(group.node, &self.entries);
        self.open.extend(children);
        self.open[first_child..].reverse();
    }
}

/// A box in the search queue.
#[derive(Clone, Copy, Debug)]
struct NearCandidate {
    bound: f64,
    node: Node,
}

/// Reversed order, because a heap pops the greatest entry first.
impl Ord for NearCandidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

impl PartialOrd for NearCandidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for NearCandidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for NearCandidate {}
