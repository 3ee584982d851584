//! Hierarchies of casters that a device builds.

use crate::recipe::shader::Module;

/// A hierarchy of eight children a node over the casters around a light, built by compute passes.
///
/// The device writes the hierarchy in place of the first table of the recipe's receive kernel. The
/// second one has the casters' corners, three rows a caster. A light set writes these on the
/// device, too, from its own vertices.
///
/// A caster has at least one reference, and further ones up to the allowed number. References are
/// sorted by keys, and each 64 are grouped into 8 nodes, which are grouped alike. Level 1 has the
/// nodes above references, and the last level one node.
///
/// The modules declare a uniform struct named [`uniforms_name`](Self::uniforms_name), and `struct
/// HierarchyPlace { unused: u32, nodes: u32, ids: u32, corners: u32, casters: u32,
/// most_references: u32, levels: u32, level: u32, firsts: array<vec4u, 3> }`. The fields are the
/// first rows of the hierarchy, its ids and the corners; the number of casters, and the greatest
/// number of references, at least as many; the number of levels, the level whose items a pass
/// groups, and the first node of each level.
///
/// The modules also declare these compute shaders, with workgroups of 64 invocations:
///
/// 1. `count_pieces` and `make_keys` (an invocation for each caster).
/// 2. The backend writes the numbers of the references to `numbers`, sorted by `keys`; equal keys
///    keep their order. It may overwrite `keys`. There are as many references as casters, plus the
///    first word of `head`, at most `most_references`.
/// 3. `build_leaves` (an invocation for each reference).
/// 4. `build_nodes` for each level below the last (an invocation for each node).
///
/// They use these bindings in group 0: `view` (the uniform struct), `made` (`HierarchyPlace`),
/// `tables: array<u32>` (four words a row), `keys` and `numbers: array<u32>` (a word a reference;
/// `numbers` is read-only), `head: array<atomic<u32>>` ([`HEAD`](Self::HEAD) words, initially 0),
/// `references: array<vec2u>` (one a reference) and `boxes: array<vec4f>` (two a node). Three rows a
/// caster contain its corners: x, y, z, and the row of its record in
/// [`CutOuts::rows`](crate::CutOuts::rows), 0 if it is opaque. The hierarchy has
/// [`HEADER`](Self::HEADER) rows, four rows a node, and then the ids, four a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceHierarchy {
    /// The WGSL modules.
    pub modules: Vec<Module>,
    /// Name of the uniform struct in WGSL.
    pub uniforms_name: &'static str,
    /// Bytes of the uniform struct. The hierarchy is valid while these and the casters are
    /// unchanged.
    pub uniforms: Vec<u8>,
    /// Number of faces on which a caster may be visible.
    pub faces: u32,
}

impl DeviceHierarchy {
    /// Number of tables that the device writes.
    pub const TABLES: usize = 2;
    /// Number of words of `head`.
    pub const HEAD: u64 = 32;
    /// Number of rows before the nodes.
    pub const HEADER: u32 = 4;
    /// Greatest number of levels, with that of references.
    pub const LEVELS: usize = 12;
}
