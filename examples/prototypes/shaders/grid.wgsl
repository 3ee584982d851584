// Lists of a grid of two levels: a tile's cells follow from its casters. Calls rects.wgsl.

struct GridPlace {
    casters: u32,
    tiles: u32,
    cells: u32,
    items: u32,
    large: u32,
}

@group(0) @binding(0) var<uniform> grid: ListsGrid;
@group(0) @binding(1) var<uniform> made: GridPlace;
@group(0) @binding(2) var<storage, read> corners: array<vec4f>;
// Number of casters of a tile, and the sums of their widths and heights, and of their areas.
@group(0) @binding(3) var<storage, read_write> tile_sums: array<atomic<u32>>;
// Number of cells of a tile, then its first cell.
@group(0) @binding(4) var<storage, read_write> tile_cells: array<u32>;
// First cell and level of each tile.
@group(0) @binding(5) var<storage, read_write> tiles: array<vec2u>;
// Number of items of a cell, then its first item.
@group(0) @binding(6) var<storage, read_write> cell_items: array<atomic<u32>>;
// Depths behind which cells are in shadow: bits of a float, subtracted from those of infinity.
@group(0) @binding(7) var<storage, read_write> covers: array<atomic<u32>>;
// Rows of the lookup's cells.
@group(0) @binding(8) var<storage, read_write> cells: array<vec4u>;
// Three words an item: caster, box, least depth.
@group(0) @binding(9) var<storage, read_write> unsorted: array<u32>;
@group(0) @binding(10) var<storage, read_write> items: array<vec2u>;
// Number of large casters, then their faces and ids; the second word is the number of casters of all
// tiles.
@group(0) @binding(11) var<storage, read_write> large: array<atomic<u32>>;

// What a pass does with each tile or cell that a caster may touch.
override DOES: u32 = 0u;
const SUM = 0u;
const COVER = 1u;
const COUNT = 2u;
const FILL = 3u;
// Greatest number of items of a tile, per caster of it.
override ITEMS: f32 = 3.0;

const FAR = 0x7f800000u;
const MOST_LEVEL = 7u;
// Rounding of positions on the grid, tiles.
const SLACK = 1.220703125e-4;
// Units of widths, and of areas, a tile.
const UNITS = 64.0;

// A caster in units of tiles.
struct OnGrid {
    shape: Shape,
    low: vec2f,
    high: vec2f,
    around: f32,
    // Depth of its plane: value at the first corner, and growth across and down.
    plane: vec3f,
    plane_error: f32,
    knows_plane: bool,
    // Twice its area; its sign is that of the edges' functions inside.
    area: f32,
}

fn on_grid(face: u32, corners: array<vec3f, 3>) -> OnGrid {
    var out: OnGrid;
    out.shape = shape_of(face, corners);
    if !out.shape.is_there {
        return out;
    }
    let scale = grid.face.z;
    // The lookup of lists knows no distances: use the greatest.
    out.around = margin(distance_to_origin(corners)) * scale + SLACK;
    let count = select(3u, 2u, out.shape.is_box);
    out.low = vec2f(3e38);
    out.high = vec2f(-3e38);
    for (var i = 0u; i < count; i++) {
        let p = (out.shape.corners[i].xy + grid.face.xy) * scale;
        out.shape.corners[i] = vec3f(p, out.shape.corners[i].z);
        out.low = min(out.low, p);
        out.high = max(out.high, p);
    }
    if !is_lamp() {
        out.shape.nearest = max(before(min(min(corners[0].z, corners[1].z), corners[2].z)), 0.0);
        out.shape.farthest = behind(max(max(corners[0].z, corners[1].z), corners[2].z));
    }
    if out.shape.is_box {
        return out;
    }
    let u = out.shape.corners[1] - out.shape.corners[0];
    let v = out.shape.corners[2] - out.shape.corners[0];
    out.area = u.x * v.y - u.y * v.x;
    let long = max(max(length(u.xy), length(v.xy)), length(u.xy - v.xy));
    let deep = max(max(abs(u.z), abs(v.z)), abs(u.z - v.z));
    out.knows_plane = !is_lamp() && abs(out.area) > long * long * 0.0625;
    if out.knows_plane {
        let across = (u.z * v.y - u.y * v.z) / out.area;
        let down = (u.x * v.z - u.z * v.x) / out.area;
        out.plane = vec3f(out.shape.corners[0].z, across, down);
        out.plane_error = deep * 6.1e-5 + (abs(across) + abs(down)) * out.around;
    }
    return out;
}

// Returns the depth range of a caster in a rectangle.
fn depths_in(on: OnGrid, low: vec2f, high: vec2f) -> vec2f {
    var out = vec2f(on.shape.nearest, on.shape.farthest);
    if on.knows_plane {
        let at = (low + high) * 0.5 - on.shape.corners[0].xy;
        let middle = on.plane.x + on.plane.y * at.x + on.plane.z * at.y;
        let half = (high - low) * 0.5;
        let reach = abs(on.plane.y) * half.x + abs(on.plane.z) * half.y + on.plane_error;
        out.x = max(out.x, before(middle - reach));
        out.y = min(out.y, behind(middle + reach));
    }
    return out;
}

// Returns whether a caster covers a rectangle.
fn covers_rect(on: OnGrid, low: vec2f, high: vec2f) -> bool {
    if on.shape.is_box {
        return false;
    }
    let middle = (low + high) * 0.5;
    let half = (high - low) * 0.5;
    let sign = select(1.0, -1.0, on.area < 0.0);
    for (var i = 0u; i < 3u; i++) {
        let p = on.shape.corners[i].xy;
        let e = (on.shape.corners[(i + 1u) % 3u].xy - p) * sign;
        let at = middle - p;
        let least = e.x * at.y - e.y * at.x - abs(e.x) * half.y - abs(e.y) * half.x;
        if least < 4.0 * on.around * (abs(e.x) + abs(e.y)) {
            return false;
        }
    }
    return true;
}

// Returns the first and last column of a row that a caster may touch, and the bounds of the part.
fn part_in_row(on: OnGrid, first: f32, last: f32) -> vec2f {
    if on.shape.is_box {
        return vec2f(on.low.x, on.high.x);
    }
    var turned_corners = on.shape.corners;
    for (var i = 0u; i < 3u; i++) {
        turned_corners[i] = turned_corners[i].yxz;
    }
    let part = clip_to_strip(turned_corners, first - on.around, last + on.around);
    return vec2f(part.low.y, part.high.y);
}

fn tile_number(face: u32, at: vec2u) -> u32 {
    return (face * grid.tiles.y + at.y) * grid.tiles.x + at.x;
}

fn sum_tile(number: u32, on: OnGrid, tile: vec2f) {
    let size = max(min(on.high, tile + 1.0) - max(on.low, tile), vec2f(0.0));
    atomicAdd(&tile_sums[3u * number], 1u);
    atomicAdd(&tile_sums[3u * number + 1u], u32(ceil((size.x + size.y) * UNITS)));
    atomicAdd(&tile_sums[3u * number + 2u], u32(size.x * size.y * UNITS * UNITS));
}

const KEY = 32.0;

fn visit_cell(cell: u32, id: u32, on: OnGrid, at: vec2f, side: f32, range: vec2f) {
    let low = at - SLACK;
    let high = at + side + SLACK;
    let depths = depths_in(on, low, high);
    if DOES == COVER {
        if covers_rect(on, low, high) {
            atomicMax(&covers[cell], FAR - bitcast<u32>(max(depths.y, 0.0)));
        }
        return;
    }
    let nearest = max(depths.x, 0.0);
    if bitcast<u32>(nearest) > FAR - atomicLoad(&covers[cell]) {
        return;
    }
    if DOES == COUNT {
        atomicAdd(&cell_items[cell], 1u);
        return;
    }
    // Lists are filled from their ends.
    let first = cells[cell].x;
    let left = atomicSub(&cell_items[cell], 1u);
    let word = 3u * (first + left - 1u);
    let steps_a_side = KEY / side;
    let from_low = (vec2f(range.x, on.low.y) - on.around - at) * steps_a_side;
    let to_high = (vec2f(range.y, on.high.y) + on.around - at) * steps_a_side;
    let least = vec2u(clamp(floor(from_low - 0.0625), vec2f(0.0), vec2f(31.0)));
    let greatest = vec2u(clamp(floor(to_high + 0.0625), vec2f(0.0), vec2f(31.0)));
    unsorted[word] = id;
    unsorted[word + 1u] = least.x | (least.y << FIELD) | ((LAST - greatest.x) << (2u * FIELD)) | ((LAST - greatest.y) << (3u * FIELD));
    unsorted[word + 2u] = bitcast<u32>(nearest);
}

fn visit_tile(face: u32, id: u32, on: OnGrid, at: vec2u) {
    let number = tile_number(face, at);
    let tile = vec2f(at);
    if DOES == SUM {
        sum_tile(number, on, tile);
        return;
    }
    let cells_of = tiles[number];
    let count = 1u << cells_of.y;
    let side = 1.0 / f32(count);
    let low = clamp(floor((on.low - on.around - tile) * f32(count)), vec2f(0.0), vec2f(f32(count - 1u)));
    let high = clamp(floor((on.high + on.around - tile) * f32(count)), vec2f(0.0), vec2f(f32(count - 1u)));
    for (var y = u32(low.y); y <= u32(high.y); y++) {
        let top = tile.y + f32(y) * side;
        let range = part_in_row(on, top, top + side);
        let first = floor((range.x - on.around - tile.x) * f32(count));
        let last = floor((range.y + on.around - tile.x) * f32(count));
        let end = u32(clamp(last + 1.0, 0.0, f32(count)));
        for (var x = u32(clamp(first, 0.0, f32(count))); x < end; x++) {
            let cell = cells_of.x + (y << cells_of.y) + x;
            visit_cell(cell, id, on, vec2f(tile.x + f32(x) * side, top), side, range);
        }
    }
}

fn tile_limits(on: OnGrid) -> vec4u {
    let last = vec2f(grid.tiles.xy) - 1.0;
    let low = clamp(floor(on.low - on.around), vec2f(0.0), last);
    let high = clamp(floor(on.high + on.around), vec2f(0.0), last);
    return vec4u(vec2u(low), vec2u(high));
}

// A caster is large if a workgroup processes it: it is longer than this part of a tile.
const LARGE = 0.25;

fn is_large(on: OnGrid) -> bool {
    return any(on.high - on.low > vec2f(LARGE));
}

@compute @workgroup_size(64)
fn visit_small(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let id = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if id >= made.casters {
        return;
    }
    let corners = corners_of(id);
    for (var face = 0u; face < faces(); face++) {
        let on = on_grid(face, corners);
        if !on.shape.is_there {
            continue;
        }
        if is_large(on) {
            if DOES == SUM {
                let place = atomicAdd(&large[0], 1u);
                if place < made.large {
                    atomicStore(&large[4u + place], id | (face << 29u));
                }
            }
            continue;
        }
        let limits = tile_limits(on);
        for (var y = limits.y; y <= limits.w; y++) {
            for (var x = limits.x; x <= limits.z; x++) {
                visit_tile(face, id, on, vec2u(x, y));
            }
        }
    }
}

// A workgroup takes every 1024th large caster, and a lane every 64th of its tiles.
@compute @workgroup_size(64)
fn visit_large(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let count = min(atomicLoad(&large[0]), made.large);
    for (var i = group.x; i < count; i += 1024u) {
        let word = atomicLoad(&large[4u + i]);
        let id = word & 0x1fffffffu;
        let face = word >> 29u;
        let on = on_grid(face, corners_of(id));
        let limits = tile_limits(on);
        let across = limits.z - limits.x + 1u;
        let all_tiles = across * (limits.w - limits.y + 1u);
        for (var t = lane; t < all_tiles; t += 64u) {
            let at = limits.xy + vec2u(t % across, t / across);
            let range = part_in_row(on, f32(at.y), f32(at.y + 1u));
            if range.x - on.around <= f32(at.x + 1u) && range.y + on.around >= f32(at.x) {
                visit_tile(face, id, on, at);
            }
        }
    }
}

// Chooses the finest level whose items are at most a multiple of the tile's casters.
@compute @workgroup_size(64)
fn choose_levels(@builtin(global_invocation_id) at: vec3u) {
    let tile = at.x;
    if tile >= made.tiles {
        return;
    }
    let count = f32(atomicLoad(&tile_sums[3u * tile]));
    let sizes = f32(atomicLoad(&tile_sums[3u * tile + 1u])) / UNITS;
    let areas = f32(atomicLoad(&tile_sums[3u * tile + 2u])) / (UNITS * UNITS);
    var level = 0u;
    for (var next = 1u; next <= MOST_LEVEL; next++) {
        let side = f32(1u << next);
        let expected = count + sizes * side + areas * side * side;
        if expected <= ITEMS * count && side * side <= 2.0 * count {
            level = next;
        }
    }
    atomicAdd(&large[1], u32(count));
    atomicStore(&tile_sums[3u * tile], level);
    tile_cells[tile] = 1u << (2u * level);
}

@compute @workgroup_size(64)
fn place_tiles(@builtin(global_invocation_id) at: vec3u) {
    let tile = at.x;
    if tile < made.tiles {
        tiles[tile] = vec2u(tile_cells[tile], atomicLoad(&tile_sums[3u * tile]));
    }
}

// Keeps the counts of cells for the scan, which replaces them by places.
@compute @workgroup_size(64)
fn keep_counts(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let cell = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if cell <= made.cells {
        cells[cell].y = atomicLoad(&cell_items[cell]);
    }
}

@compute @workgroup_size(64)
fn place_cells(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let cell = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if cell > made.cells {
        return;
    }
    let count = cells[cell].y;
    let first = atomicLoad(&cell_items[cell]);
    atomicStore(&cell_items[cell], count);
    cells[cell] = vec4u(first, FAR - atomicLoad(&covers[cell]), FAR, 0u);
}

// Sorts a list by steps of depth.
@compute @workgroup_size(64)
fn sort_items(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let cell = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if cell >= made.cells {
        return;
    }
    let first = cells[cell].x;
    let end = cells[cell + 1u].x;
    var least = FAR;
    var greatest = 0u;
    for (var i = first; i < end; i++) {
        let depth = unsorted[3u * i + 2u];
        least = min(least, depth);
        greatest = max(greatest, depth);
    }
    let nearest = bitcast<f32>(least);
    let width = bitcast<f32>(greatest) - nearest;
    var steps = 0.0;
    if width > 1e-30 {
        steps = (KEY - 1.0) / width;
    }
    cells[cell].z = least;
    cells[cell].w = bitcast<u32>(steps);
    var places: array<u32, 32>;
    for (var i = first; i < end; i++) {
        places[step_of(i, nearest, steps)] += 1u;
    }
    var next = first;
    for (var i = 0u; i < 32u; i++) {
        let count = places[i];
        places[i] = next;
        next += count;
    }
    for (var i = first; i < end; i++) {
        let step = step_of(i, nearest, steps);
        items[places[step]] = vec2u(unsorted[3u * i], unsorted[3u * i + 1u] | (step << (4u * FIELD)));
        places[step] += 1u;
    }
}

fn step_of(item: u32, nearest: f32, steps: f32) -> u32 {
    let depth = bitcast<f32>(unsorted[3u * item + 2u]);
    return u32(clamp((depth - nearest) * steps, 0.0, KEY - 1.0));
}
