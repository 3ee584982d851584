// Visits of each cell that a caster may touch: find covered cells, count items, fill in items.

// Action of a pass for each cell that a caster may touch. It is a pipeline constant, since drivers
// that run on the CPU execute all branches of a shader, taken or not.
override DOES: u32 = 0u;
const COVER = 0u;
const COUNT = 1u;
const FILL = 2u;
// Tolerance of the edges' functions below -1, and the extension of the cells of a row. Both are
// larger where items are counted, since rounding may differ between the passes.
const COUNTED_MISS = -1.0625;
const FILLED_MISS = -1.0;
const COUNTED_MORE = 0.125;
const FILLED_MORE = 0.0625;

fn cell_number(face: u32, cell: vec2u) -> u32 {
    let side = side_log2();
    let tile = cell >> vec2u(side);
    let in_tile = cell - (tile << vec2u(side));
    let tile_number = (face * grid.tiles.y + tile.y) * grid.tiles.x + tile.x;
    return (((tile_number << side) + in_tile.y) << side) + in_tile.x;
}

// Processes a caster in a row of cells.
fn visit_row(id: u32, touch: Touch, edges: Edges, y: u32) {
    let shift = STEPS - side_log2();
    let cell_side = 1.0 / (grid.face.z * f32(1u << side_log2()));
    let row = row_of(edges, y, cell_side);
    var cells = vec2f(0.0);
    if DOES == COVER {
        cells = covered_cells(row);
    } else {
        let least = select(FILLED_MISS, COUNTED_MISS, DOES == COUNT);
        let more = select(FILLED_MORE, COUNTED_MORE, DOES == COUNT);
        cells = touched_cells(row, least, more);
    }
    let first = u32(max(cells.x, f32(touch.low.x >> shift)));
    let end = u32(max(min(cells.y, f32(touch.high.x >> shift)) + 1.0, 0.0));
    for (var x = first; x < end; x++) {
        if DOES == COVER {
            let farthest = max(farthest_in_cell(row, x), 0.0);
            atomicMax(&work[cell_word(cell_number(touch.face, vec2u(x, y))) + 1u], FAR - bitcast<u32>(farthest));
        } else {
            let nearest = select(touch.nearest, max(touch.nearest, nearest_in_cell(row, x)), edges.knows_depth);
            visit_cell(id, touch, nearest, vec2u(x, y));
        }
    }
}

fn visit_cell(id: u32, touch: Touch, nearest: f32, cell: vec2u) {
    let number = cell_number(touch.face, cell);
    if DOES == COUNT {
        count_item(number, nearest);
    } else {
        fill_item(number, id, nearest, touch, cell);
    }
}

// Returns a slightly smaller depth, to allow for different rounding when items are filled in.
fn counted_depth(nearest: f32) -> f32 {
    return max(nearest * (1.0 - 1.0 / 65536.0) - 1e-30, 0.0);
}

fn cover_of(number: u32) -> u32 {
    return FAR - atomicLoad(&work[cell_word(number) + 1u]);
}

fn count_item(number: u32, nearest: f32) {
    if bitcast<u32>(counted_depth(nearest)) <= cover_of(number) {
        atomicAdd(&work[cell_word(number)], 1u);
    }
}

@compute @workgroup_size(64)
fn visit_small(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    if !touches_fit() {
        return;
    }
    // A point light's casters touch several faces, so there may be more touches than threads.
    let count = atomicLoad(&work[SMALL]);
    let stride = groups.x * groups.y * 64u;
    for (var place = at.x + at.y * groups.x * 64u; place < count; place += stride) {
        visit_touch(place);
    }
}

fn visit_touch(place: u32) {
    let touch = kept_touch(place);
    let shift = vec2u(STEPS - side_log2());
    let low = touch.low >> shift;
    let high = touch.high >> shift;
    let id = kept_id(place);
    // Use all of so few cells: testing which of them it misses costs more than occasional useless
    // tests.
    let in_box = all(high - low <= vec2u(1u));
    if in_box && DOES != COVER {
        for (var i = 0u; i < 4u; i++) {
            let cell = low + vec2u(i % 2u, i / 2u);
            if all(cell <= high) {
                visit_cell(id, touch, touch.nearest, cell);
            }
        }
    }
    if in_box {
        return;
    }
    let edges = edges_of(touch.face, corners_of(id));
    if DOES == COVER && !edges.knows_depth {
        return;
    }
    for (var y = low.y; y <= high.y; y++) {
        visit_row(id, touch, edges, y);
    }
}

// A workgroup takes every `groups.x`th large caster; each thread takes a row of its cells.
@compute @workgroup_size(64)
fn visit_large(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    if !touches_fit() {
        return;
    }
    let count = atomicLoad(&work[LARGE]);
    let shift = STEPS - side_log2();
    for (var i = group.x; i < count; i += groups.x) {
        let place = large_place(i);
        let touch = kept_touch(place);
        let first = (touch.low.y >> shift) + lane + 64u * group.y;
        let last = touch.high.y >> shift;
        if first > last {
            continue;
        }
        let edges = kept_edges(place);
        if DOES == COVER && !edges.knows_depth {
            continue;
        }
        let id = kept_id(place);
        for (var y = first; y <= last; y += 64u * groups.y) {
            visit_row(id, touch, edges, y);
        }
    }
}
