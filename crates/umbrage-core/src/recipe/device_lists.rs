//! Per-cell triangle lists that a device builds.

use crate::recipe::{Recipe, shader::Module};

/// Lists of the casters in the cells of a grid around a light, built by compute passes. For
/// renderers whose vertices exist only on the device. They replace the tables of the recipe's
/// kernel, in this order: tiles, cells, items, corners.
///
/// The modules declare a uniform struct named [`uniforms_name`](Self::uniforms_name), `struct
/// ListsPlace { rows: vec4u, triangles: u32, items: u32, touches: u32, cells: u32 }`, and `override
/// DOES: u32`. The fields of `ListsPlace` are the tables' first rows, the number of casters, and
/// the capacity for items, rows of touches, and cells of the first attempt.
///
/// The modules also declare the compute shaders below, which run in this order. Each has one
/// invocation for each of the things in brackets. Workgroups have 64 invocations, or 256 for blocks
/// of 1,024 cells.
///
/// 1. `note_touches` (casters).
/// 2. An attempt: `visit_small` (casters) and `visit_large` (any number of workgroups in both
///    directions), each with `DOES` 0 (casters cover cells), then 1 (count items); `sum_blocks`
///    (blocks); `sum_all` (one workgroup), which determines whether the capacity suffices.
/// 3. If it doesn't, further attempts, each after `clear_cells` (cells).
/// 4. `place_cells` (blocks, and one more cell), `visit_small` and `visit_large` with `DOES` 2
///    (write items), `sort_items` (cells).
///
/// They use these bindings in group 0: `grid` (the uniform struct), `made` (`ListsPlace`),
/// `tables: array<u32>` (four words a row; three rows a caster contain its corners, x, y, z,
/// unused), `work: array<atomic<u32>>` ([`work_words`](Self::work_words) words, initially 0),
/// `unsorted: array<u32>` (three words an item) and `touches: array<vec4u>`. `sum_all` also writes
/// `further: array<u32>` in group 1: it sets all of it to 0 once the capacity suffices. Backends
/// store the indirect dispatch arguments of further attempts there.
///
/// At the end, the first word of `work` is 1 if the capacity sufficed. The second word is the
/// number of times the cells were made twice as wide. The three words from [`NEEDED`](Self::NEEDED)
/// on are the number of items that the first attempt needs, the number of touches of large casters
/// ([`LARGE_TOUCH`](Self::LARGE_TOUCH) rows each), and that of small ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceLists {
    /// The WGSL modules.
    pub modules: Vec<Module>,
    /// Name of the uniform struct in WGSL.
    pub uniforms_name: &'static str,
    /// Bytes of the uniform struct. The lists are valid while these and the casters are unchanged.
    pub uniforms: Vec<u8>,
    /// Number of tiles of all faces.
    pub tiles: u32,
    /// Cells along a tile's side at the first attempt, as a power of two.
    pub side_log2: u32,
    /// Number of faces on which a caster may be visible.
    pub faces: u32,
}

impl DeviceLists {
    /// Number of words at the beginning of `work` that describe the result.
    pub const HEAD: u64 = 16;
    /// Index of the first word of `work` that describes what the first attempt needs.
    pub const NEEDED: u64 = 3;
    /// Number of rows of `touches` per large caster.
    pub const LARGE_TOUCH: u32 = 5;
    /// Number of cells per block.
    pub const BLOCK: u32 = 1024;

    /// Returns the number of cells of the first attempt.
    pub fn cells(&self) -> u32 {
        self.tiles << (2 * self.side_log2)
    }

    /// Returns the number of words of `work`.
    pub fn work_words(&self) -> u64 {
        let cells = u64::from(self.cells());
        Self::HEAD + cells.div_ceil(u64::from(Self::BLOCK)) + 2 * cells
    }
}

/// A recipe whose tables are built by a device.
#[derive(Clone, Debug)]
pub struct DeviceRecipe {
    /// The recipe, with tables for a scene without casters. The device's tables replace them.
    pub recipe: Recipe,
    /// The lists that the device builds.
    pub lists: DeviceLists,
}
