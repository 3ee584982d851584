// Casters walk over the receivers of the cells that they touch. Calls rects.wgsl, and the library's
// triangle test.

struct BinsPlace {
    casters: u32,
    side: u32,
    cells: u32,
    large: u32,
    image: vec2u,
    half: vec2f,
    // First place in each cell's list that a pass walks, and number of places.
    slice: vec2u,
}

@group(0) @binding(0) var<uniform> kernel: ExactUniforms;
@group(0) @binding(1) var<uniform> made: BinsPlace;
@group(0) @binding(2) var<uniform> grid: ListsGrid;
@group(0) @binding(3) var<storage, read> corners: array<vec4f>;
// First receiver of each cell.
@group(0) @binding(4) var<storage, read> counts: array<u32>;
@group(0) @binding(5) var<storage, read> deepest: array<u32>;
@group(0) @binding(6) var<storage, read> binned: array<vec4u>;
@group(0) @binding(7) var<storage, read> ends: array<u32>;
@group(0) @binding(8) var<storage, read_write> answers: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read> table_3: array<vec4u>;
@group(0) @binding(10) var<storage, read> table_4: array<vec4u>;
// Number of large casters, then their faces and ids.
@group(0) @binding(11) var<storage, read_write> large: array<atomic<u32>>;
// Receivers walked and tested, two words a pixel.
@group(0) @binding(12) var<storage, read_write> counted: array<atomic<u32>>;
// Cells visited; sum over blocks of 32 lanes of the longest walk; longest walk.
@group(0) @binding(13) var<storage, read_write> walks: array<atomic<u32>>;

override COUNTS: bool = false;

var<private> steps_walked: u32;
var<private> cells_walked: u32;

fn from_ordered(word: u32) -> f32 {
    return bitcast<f32>(select(~word, word & 0x7fffffffu, (word >> 31u) == 1u));
}

// Position on a face, in cells.
fn in_cells(p: vec2f) -> vec2f {
    var low = vec2f(-1.0);
    var high = vec2f(1.0);
    if !is_lamp() {
        low = vec2f(from_ordered(~ends[0]), from_ordered(~ends[1]));
        high = max(vec2f(from_ordered(ends[2]), from_ordered(ends[3])), low + 1e-6);
    }
    return (p - low) * (f32(made.side) / (high - low));
}

// Rounding of a position in cells.
const CELL_SLACK = 0.001;

fn test_receiver(place: u32, id: u32, rect: Rect) {
    let second = binned[2u * place + 1u];
    steps_walked += 1u;
    if COUNTS {
        atomicAdd(&counted[2u * second.w], 1u);
    }
    let at = bitcast<vec3f>(second.xyz);
    if any(at.xy < rect.low) || any(at.xy > rect.high) || at.z < rect.nearest {
        return;
    }
    if atomicLoad(&answers[second.w]) == 0u {
        return;
    }
    let first = binned[2u * place];
    if first.w == id {
        return;
    }
    let o = bitcast<vec3f>(first.xyz);
    let d = segment(kernel.light, o, vec2f(0.0), kernel.far);
    if COUNTS {
        atomicAdd(&counted[2u * second.w + 1u], 1u);
    }
    if meets_caster(o, d, shear_rows(d), id) {
        atomicStore(&answers[second.w], 0u);
    }
}

fn test_cell(face: u32, x: u32, y: u32, id: u32, rect: Rect) {
    let cell = (face * made.side + y) * made.side + x;
    cells_walked += 1u;
    steps_walked += 1u;
    let first = counts[cell] + made.slice.x;
    let end = min(counts[cell + 1u], first + made.slice.y);
    if first >= end || bitcast<f32>(deepest[cell]) < rect.nearest {
        return;
    }
    for (var place = first; place < end; place++) {
        test_receiver(place, id, rect);
    }
}

struct Walk {
    // Rectangle on the face, with all margins.
    rect: Rect,
    low: vec2f,
    high: vec2f,
    shape: Shape,
}

fn walk_of(face: u32, points: array<vec3f, 3>) -> Walk {
    var out: Walk;
    out.shape = shape_of(face, points);
    if !out.shape.is_there {
        return out;
    }
    // Here no lookup adds the error that grows with the distance: use the greatest.
    out.shape.around = margin(distance_to_origin(points));
    out.rect = rect_of(face, out.shape, 0u, 1u);
    out.rect.nearest = out.shape.nearest;
    if !is_lamp() {
        out.rect.nearest = max(before(min(min(points[0].z, points[1].z), points[2].z)), 0.0);
    }
    let shift = vec2f(select(0.0, FACE_STEP * f32(face), is_lamp()), 0.0);
    out.rect.low -= shift;
    out.rect.high -= shift;
    // Shifts are rounded.
    if is_lamp() {
        out.rect.low -= 4e-6;
        out.rect.high += 4e-6;
    }
    out.low = floor(in_cells(out.rect.low) - CELL_SLACK);
    out.high = floor(in_cells(out.rect.high) + CELL_SLACK);
    let last = f32(made.side) - 1.0;
    let misses = any(out.high < vec2f(0.0)) || any(out.low > vec2f(last));
    out.shape.is_there = out.rect.is_there && !misses;
    out.low = clamp(out.low, vec2f(0.0), vec2f(last));
    out.high = clamp(out.high, vec2f(0.0), vec2f(last));
    return out;
}

// Longest side of a small caster, cells.
const SMALL = 8.0;

var<workgroup> lanes: array<u32, 64>;

fn note_walk(lane: u32) {
    if !COUNTS {
        return;
    }
    lanes[lane] = steps_walked;
    workgroupBarrier();
    if made.slice.x == 0u {
        atomicAdd(&walks[0], cells_walked);
    }
    if lane % 32u == 0u {
        var longest = 0u;
        for (var i = lane; i < lane + 32u; i++) {
            longest = max(longest, lanes[i]);
        }
        atomicAdd(&walks[1], longest);
        atomicMax(&walks[2], longest);
    }
}

@compute @workgroup_size(64)
fn cast_small(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    opaque_zero = kernel.light.shape.x >> 31u;
    let id = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if id < made.casters {
        let points = corners_of(id);
        for (var face = 0u; face < faces(); face++) {
            let walk = walk_of(face, points);
            if !walk.shape.is_there {
                continue;
            }
            if any(walk.high - walk.low >= vec2f(SMALL)) {
                if made.slice.x == 0u {
                    let place = atomicAdd(&large[0], 1u);
                    if place < made.large {
                        atomicStore(&large[4u + place], id | (face << 29u));
                    }
                }
                continue;
            }
            for (var y = u32(walk.low.y); y <= u32(walk.high.y); y++) {
                for (var x = u32(walk.low.x); x <= u32(walk.high.x); x++) {
                    test_cell(face, x, y, id, walk.rect);
                }
            }
        }
    }
    note_walk(lane);
}

// Returns whether a triangle may touch a cell: none of its edges has it outside.
fn may_touch(walk: Walk, x: f32, y: f32) -> bool {
    if walk.shape.is_box {
        return true;
    }
    let a = in_cells(walk.shape.corners[0].xy);
    let b = in_cells(walk.shape.corners[1].xy);
    let c = in_cells(walk.shape.corners[2].xy);
    let around = in_cells(vec2f(walk.shape.around)) - in_cells(vec2f(0.0)) + 0.01;
    let middle = vec2f(x, y) + 0.5;
    let reach = vec2f(0.5) + 2.0 * around;
    let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let sign = select(1.0, -1.0, area < 0.0);
    return most_of(a, b, middle, reach, sign) >= 0.0 && most_of(b, c, middle, reach, sign) >= 0.0 && most_of(c, a, middle, reach, sign) >= 0.0;
}

// Returns the greatest value of an edge's function in a cell, with its rounding.
fn most_of(p: vec2f, q: vec2f, middle: vec2f, reach: vec2f, sign: f32) -> f32 {
    let e = (q - p) * sign;
    let at = middle - p;
    let rounding = (abs(e.x * at.y) + abs(e.y * at.x)) * 1e-6;
    return e.x * at.y - e.y * at.x + abs(e.x) * reach.y + abs(e.y) * reach.x + rounding;
}

// A workgroup takes every 4096th large caster, and a lane every 64th of its cells.
@compute @workgroup_size(64)
fn cast_large(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    opaque_zero = kernel.light.shape.x >> 31u;
    let count = min(atomicLoad(&large[0]), made.large);
    for (var i = group.x; i < count; i += 4096u) {
        let word = atomicLoad(&large[4u + i]);
        let id = word & 0x1fffffffu;
        let face = word >> 29u;
        let walk = walk_of(face, corners_of(id));
        let low = vec2u(walk.low);
        let size = vec2u(walk.high) - low + 1u;
        for (var cell = lane; cell < size.x * size.y; cell += 64u) {
            let at = low + vec2u(cell % size.x, cell / size.x);
            steps_walked += 1u;
            if may_touch(walk, f32(at.x), f32(at.y)) {
                test_cell(face, at.x, at.y, id, walk.rect);
            }
        }
    }
    note_walk(lane);
}
