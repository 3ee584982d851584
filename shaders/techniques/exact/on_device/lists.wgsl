// Builds the tables that exact.wgsl reads, from the casters' corners, with the compute passes in
// `DeviceLists` of `umbrage-core`.
//
// Counting, prefix sums and filling in are the counting sort of Knuth 1973, "The Art of Computer
// Programming" 3, 5.2.

struct ListsPlace {
    // First rows of tiles, cells, items and corners among the tables.
    rows: vec4u,
    triangles: u32,
    // Maximum number of items.
    items: u32,
    // Maximum number of touches.
    touches: u32,
    // Number of cells in the first attempt.
    cells: u32,
}

@group(0) @binding(0) var<uniform> grid: ListsGrid;
@group(0) @binding(1) var<uniform> made: ListsPlace;
@group(0) @binding(2) var<storage, read_write> tables: array<u32>;
@group(0) @binding(3) var<storage, read_write> work: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> unsorted: array<u32>;
@group(0) @binding(5) var<storage, read_write> touches: array<vec4u>;

// Head of `work`.
const FITS = 0u;
const HALVED = 1u;
const TOTAL = 2u;
// Number of items in the first attempt; then touches of large casters and of small ones.
const NEEDED = 3u;
const LARGE = 4u;
const SMALL = 5u;
const HEAD = 16u;
// Sums of blocks, then two words per cell. The first is the number of items. The second is the
// depth beyond which everything is in shadow: the bits of a positive float, which compare like it,
// subtracted from those of infinity, so that 0 is the farthest.
const BLOCK = 1024u;
const CELL_WORDS = 2u;
const FAR = 0x7f800000u;

// Number of cells beyond which a caster is processed by many threads.
const MANY_CELLS = 16u;
// Number of rows of touches that one of these uses.
const LARGE_TOUCH = 5u;

fn side_log2() -> u32 {
    return grid.tiles.w - min(atomicLoad(&work[HALVED]), grid.tiles.w);
}

fn tile_count() -> u32 {
    return faces() * grid.tiles.x * grid.tiles.y;
}

fn cell_count() -> u32 {
    return tile_count() << (2u * side_log2());
}

fn blocks() -> u32 {
    return (made.cells + BLOCK - 1u) / BLOCK;
}

fn cell_word(cell: u32) -> u32 {
    return HEAD + blocks() + CELL_WORDS * cell;
}

fn corners_of(id: u32) -> array<vec3f, 3> {
    var corners: array<vec3f, 3>;
    for (var i = 0u; i < 3u; i++) {
        let word = 4u * (made.rows.w + 3u * id + i);
        let p = vec3u(tables[word], tables[word + 1u], tables[word + 2u]);
        corners[i] = frame_point(bitcast<vec3f>(p));
    }
    return corners;
}

@compute @workgroup_size(64)
fn note_touches(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let id = at.x + at.y * groups.x * 64u;
    if id >= made.triangles {
        return;
    }
    let corners = corners_of(id);
    for (var face = 0u; face < faces(); face++) {
        let touch = touch_on(face, corners);
        if touch.face == NO_FACE {
            continue;
        }
        let shift = STEPS - grid.tiles.w;
        let size = (touch.high >> vec2u(shift)) - (touch.low >> vec2u(shift)) + 1u;
        if size.x * size.y > MANY_CELLS {
            let number = atomicAdd(&work[LARGE], 1u);
            if LARGE_TOUCH * (number + 1u) <= made.touches {
                keep_touch(large_place(number), id, touch);
                keep_edges(large_place(number), edges_of(face, corners));
            }
        } else {
            let place = atomicAdd(&work[SMALL], 1u);
            if place < made.touches {
                keep_touch(place, id, touch);
            }
        }
    }
}

fn touches_fit() -> bool {
    return LARGE_TOUCH * atomicLoad(&work[LARGE]) + atomicLoad(&work[SMALL]) <= made.touches;
}

@compute @workgroup_size(64)
fn clear_cells(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let cell = at.x + at.y * groups.x * 64u;
    if cell >= cell_count() {
        return;
    }
    let word = cell_word(cell);
    atomicStore(&work[word], 0u);
    atomicStore(&work[word + 1u], 0u);
}
