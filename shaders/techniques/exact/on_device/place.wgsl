// Inputs and outputs of the passes that build a hierarchy. A row of `tables` is four words.

struct HierarchyPlace {
    unused: u32,
    // First rows of the hierarchy (its header, then four rows a node), of its ids (four a row), and
    // of the casters' corners (three rows a caster: x, y, z; the second one ends with its record).
    nodes: u32,
    ids: u32,
    corners: u32,
    casters: u32,
    // Greatest number of references, at least that of the casters.
    most_references: u32,
    // Number of levels of nodes, and the level whose items a pass groups: 0 for references.
    levels: u32,
    level: u32,
    // First node of each level, from 1 on.
    firsts: array<vec4u, 3>,
}

@group(0) @binding(0) var<uniform> view: LightView;
@group(0) @binding(1) var<uniform> made: HierarchyPlace;
@group(0) @binding(2) var<storage, read_write> tables: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys: array<u32>;
// Numbers of the references, sorted by their keys.
@group(0) @binding(4) var<storage, read> numbers: array<u32>;
@group(0) @binding(5) var<storage, read_write> head: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> references: array<vec2u>;
// Low and high corner of each node's box.
@group(0) @binding(7) var<storage, read_write> boxes: array<vec4f>;

// Words of `head`: the number of references beyond the first of each caster; those without pieces;
// and the number of further pieces at each step.
const MORE = 0u;
const MORE_WHOLE = 1u;
const MORE_PIECES = 2u;

// Rows of the header: the number of levels, the first row of the ids after that of the header, and
// the number of references; then `firsts`.
const HEADER = 4u;
// Second word of a reference without a caster, and its key.
const NO_REFERENCE = 0xffffffffu;

fn first_of(level: u32) -> u32 {
    return made.firsts[level / 4u][level % 4u];
}

fn put_row(row: u32, value: vec4u) {
    for (var i = 0u; i < 4u; i++) {
        tables[4u * row + i] = value[i];
    }
}

fn corners_of(id: u32) -> array<vec3f, 3> {
    var out: array<vec3f, 3>;
    for (var i = 0u; i < 3u; i++) {
        let word = 4u * (made.corners + 3u * id + i);
        let p = vec3u(tables[word], tables[word + 1u], tables[word + 2u]);
        out[i] = frame_point(bitcast<vec3f>(p));
    }
    return out;
}
