//! Numbers of references and nodes of a hierarchy that a device builds.

use umbrage_core::DeviceHierarchy;

/// Number of children of a node.
const WIDE: u32 = 8;
/// Least number of levels of nodes: a workgroup builds nodes of 64 references.
const LEAST_LEVELS: usize = 2;
/// Rows of a node.
const NODE_ROWS: u32 = 4;
/// References in a row of ids.
const IDS_A_ROW: u32 = 4;

/// Levels of a hierarchy with a capacity for references.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct HierarchyLayout {
    /// Greatest number of references.
    pub(crate) capacity: u32,
    /// Number of levels of nodes.
    pub(crate) levels: u32,
    /// First node of each level, from level 1 on.
    pub(crate) firsts: [u32; DeviceHierarchy::LEVELS],
    /// Number of nodes of all levels.
    pub(crate) nodes: u32,
}

impl HierarchyLayout {
    /// Returns the levels for a capacity, at most 2^31.
    pub(crate) fn new(capacity: u32) -> Self {
        let mut layout = Self {
            capacity,
            ..Self::default()
        };
        let mut count = capacity;
        let mut level = 0;
        while level < LEAST_LEVELS || count > 1 {
            level += 1;
            count = count.div_ceil(WIDE).max(1);
            layout.firsts[level] = layout.nodes;
            layout.nodes += count;
        }
        layout.levels = level as u32;
        layout
    }

    /// Returns the first row of the ids, after the header and the nodes.
    pub(crate) fn first_id_row(&self) -> u32 {
        DeviceHierarchy::HEADER + NODE_ROWS * self.nodes
    }

    /// Returns the number of rows.
    pub(crate) fn rows(&self) -> u32 {
        self.first_id_row() + self.capacity.div_ceil(IDS_A_ROW)
    }
}

/// Returns the number of items that are grouped into the nodes of the next level: references at
/// level 0, otherwise nodes.
pub(crate) fn count_at(level: u32, references: u32) -> u32 {
    (0..level).fold(references, |count, _| count.div_ceil(WIDE).max(1))
}

#[cfg(test)]
mod tests {
    use super::{HierarchyLayout, count_at};

    /// Levels follow one another without gaps, and the last one is one node.
    #[test]
    fn levels_are_contiguous_and_end_at_one_node() {
        for capacity in [0, 1, 8, 9, 64, 65, 512, 513, 1_000_000, 1 << 31] {
            let layout = HierarchyLayout::new(capacity);
            let mut next = 0;
            for level in 1..=layout.levels {
                assert_eq!(layout.firsts[level as usize], next, "{capacity}, {level}");
                next += count_at(level, capacity);
            }
            assert_eq!(layout.nodes, next, "{capacity}");
            assert_eq!(count_at(layout.levels, capacity), 1, "{capacity}");
        }
    }
}
