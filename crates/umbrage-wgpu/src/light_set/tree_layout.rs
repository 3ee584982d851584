//! Numbers of references and nodes of a hierarchy that a device builds.

/// Number of children of a node.
const WIDE: u32 = 8;
/// Greatest number of levels: `MOST_LEVELS` in hierarchy.wgsl, which also counts references.
const MOST_LEVELS: usize = 12;
/// Least number of levels of nodes: a workgroup builds nodes of 64 references.
const LEAST_LEVELS: usize = 2;
/// Rows of the header before the nodes: `HEADER` in place.wgsl and hierarchy.wgsl.
const HEADER: u32 = 4;
/// Rows of a node.
const NODE_ROWS: u32 = 4;

/// Levels of a hierarchy with a capacity for references.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TreeLayout {
    /// Greatest number of references.
    pub(crate) capacity: u32,
    /// Number of levels of nodes.
    pub(crate) levels: u32,
    /// First node of each level, from level 1 on.
    pub(crate) firsts: [u32; MOST_LEVELS],
    /// Number of nodes of all levels.
    pub(crate) nodes: u32,
}

impl TreeLayout {
    /// Returns the levels for this capacity, at most 2^31.
    pub(crate) fn new(capacity: u32) -> Self {
        let mut layout = Self {
            capacity,
            ..Self::default()
        };
        let mut count = capacity.max(1);
        let mut level = 0;
        while level < LEAST_LEVELS || count > 1 {
            level += 1;
            count = count.div_ceil(WIDE);
            layout.firsts[level] = layout.nodes;
            layout.nodes += count;
        }
        layout.levels = level as u32;
        layout
    }

    /// Returns the number of rows of the nodes with their header, and of the ids.
    pub(crate) fn rows(&self) -> [u64; 2] {
        let nodes = u64::from(HEADER) + u64::from(NODE_ROWS) * u64::from(self.nodes);
        [nodes, u64::from(self.capacity.div_ceil(4))]
    }

    /// Returns the number of items that are grouped into the nodes of the next level: references at
    /// level 0, otherwise nodes.
    pub(crate) fn count_at(&self, level: u32) -> u32 {
        (0..level).fold(self.capacity, |count, _| count.div_ceil(WIDE))
    }
}

#[cfg(test)]
mod tests {
    use super::TreeLayout;

    /// Levels follow one another without gaps, and the last one is one node.
    #[test]
    fn levels_are_contiguous_and_end_at_one_node() {
        for capacity in [1, 8, 9, 64, 65, 512, 513, 1_000_000, 1 << 31] {
            let layout = TreeLayout::new(capacity);
            let mut next = 0;
            for level in 1..=layout.levels {
                assert_eq!(layout.firsts[level as usize], next, "{capacity}, {level}");
                next += layout.count_at(level);
            }
            assert_eq!(layout.nodes, next, "{capacity}");
            assert_eq!(layout.count_at(layout.levels), 1, "{capacity}");
        }
    }
}
