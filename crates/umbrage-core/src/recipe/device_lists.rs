//! Lists of casters that a device makes itself.

use crate::recipe::{Recipe, shader::Module};

/// Lists of the casters in the cells of a grid around a light, which a device makes by compute
/// passes: for renderers whose casters' vertices are on the device alone. They become the tables of
/// the recipe's kernel, in this order: tiles, cells, items, corners.
///
/// The modules declare one uniform struct, [`uniforms_name`](Self::uniforms_name), `struct
/// ListsPlace { rows: vec4u, triangles: u32, items: u32, touches: u32, cells: u32 }` (the tables'
/// first rows, how many casters there are, and for how many items, rows of touches, and cells of
/// the first try there is room), an `override DOES: u32`, and these compute shaders, which are run
/// in this order. In brackets: what there is an invocation for; groups have 64 of them, and for
/// blocks of 1,024 cells 256.
///
/// `note_touches` (casters). Then a try: `visit_small` (casters) and `visit_large` (groups of
/// threads, as many as wanted in both directions), each with `DOES` 0 (casters that cover cells),
/// then 1 (items are counted); `sum_blocks` (blocks); `sum_all` (one group), which knows whether
/// there is room. If there is none, further tries, each after `clear_cells` (cells). Then
/// `place_cells` (blocks, and one cell more), `visit_small` and `visit_large` with `DOES` 2 (items
/// are filled in), `sort_items` (cells).
///
/// They read and write, in group 0, `grid` (the uniform struct), `made` (`ListsPlace`),
/// `tables: array<u32>` (four words a row; three rows a caster hold its corners, x, y, z, unused),
/// `work: array<atomic<u32>>` ([`work_words`](Self::work_words) of them, 0 at the beginning),
/// `unsorted: array<u32>` (three words an item) and `touches: array<vec4u>`. `sum_all` also writes,
/// in group 1, `further: array<u32>`: 0 into all of it once there is room. Backends keep there what
/// passes of further tries are dispatched by. At the end the second word of `work` tells how often
/// cells were made twice as wide, the first one is 1 if the lists had room then, and from
/// [`NEEDED`](Self::NEEDED) on three words say how many items the first try needs, how many touches
/// of large casters ([`LARGE_TOUCH`](Self::LARGE_TOUCH) rows each), and how many of small ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceLists {
    /// The WGSL.
    pub modules: Vec<Module>,
    /// The uniform struct's name in WGSL.
    pub uniforms_name: &'static str,
    /// Its bytes. While they stay the same, and the casters, so do the lists.
    pub uniforms: Vec<u8>,
    /// Tiles of all faces.
    pub tiles: u32,
    /// Cells along a tile's side at the first try, as a power of two.
    pub side_log2: u32,
    /// Faces on which a caster may show.
    pub faces: u32,
}

impl DeviceLists {
    /// Words at the beginning of `work` that say how lists were made.
    pub const HEAD: u64 = 16;
    /// The first of the words of `work` that say what the first try needs.
    pub const NEEDED: u64 = 3;
    /// Rows of `touches` that a large caster takes.
    pub const LARGE_TOUCH: u32 = 5;
    /// Cells of a block.
    pub const BLOCK: u32 = 1024;

    /// Returns the cells of the first try.
    pub fn cells(&self) -> u32 {
        self.tiles << (2 * self.side_log2)
    }

    /// Returns the words of `work`.
    pub fn work_words(&self) -> u64 {
        let cells = u64::from(self.cells());
        Self::HEAD + cells.div_ceil(u64::from(Self::BLOCK)) + 2 * cells
    }
}

/// A recipe whose tables a device makes.
#[derive(Clone, Debug)]
pub struct DeviceRecipe {
    /// The recipe. Its tables are those of no casters: the device's take their place.
    pub recipe: Recipe,
    /// What makes them.
    pub lists: DeviceLists,
}
