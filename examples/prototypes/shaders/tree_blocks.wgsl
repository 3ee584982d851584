// Nodes of a hierarchy of 8 children. A workgroup takes 64 neighbours along the curve and divides
// them into 8 groups of 8: three times into halves, across the axis with the smallest halves.

struct TreePlace {
    casters: u32,
    capacity: u32,
    levels: u32,
    level: u32,
    firsts: array<vec4u, 3>,
}

@group(0) @binding(0) var<uniform> grid: ListsGrid;
@group(0) @binding(1) var<uniform> made: TreePlace;
@group(0) @binding(2) var<storage, read> corners: array<vec4f>;
@group(0) @binding(3) var<storage, read> values: array<u32>;
@group(0) @binding(4) var<storage, read> head: array<u32>;
// Four rows a node.
@group(0) @binding(5) var<storage, read_write> nodes: array<vec4u>;
// Rectangle and least depth of each node.
@group(0) @binding(6) var<storage, read_write> rects: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> nearests: array<f32>;
@group(0) @binding(8) var<storage, read> references: array<vec2u>;
// Casters in the order of the curve.
@group(0) @binding(9) var<storage, read_write> ids: array<u32>;

// Number of pseudo-axes: across, down, size, depth.
override AXES: u32 = 3u;

const NOTHING = 3e38;

var<workgroup> item_rects: array<vec4f, 64>;
var<workgroup> item_nearests: array<f32, 64>;
var<workgroup> item_numbers: array<u32, 64>;
var<workgroup> item_ranks: array<vec4u, 64>;
// Size of each half of each part across each axis.
var<workgroup> half_sizes: array<f32, 32>;

fn first_of(level: u32) -> u32 {
    return made.firsts[level / 4u][level % 4u];
}

// Returns the number of nodes of a level; of casters at level 0.
fn count_at(level: u32) -> u32 {
    var count = min(head[0], made.capacity);
    for (var i = 0u; i < level; i++) {
        count = (count + 7u) / 8u;
    }
    return count;
}

fn size_of(rect: vec4f) -> f32 {
    let size = max(rect.zw - rect.xy, vec2f(0.0));
    return size.x * size.y;
}

fn axis_keys(i: u32) -> vec4f {
    let rect = item_rects[i];
    if rect.x > rect.z {
        return vec4f(NOTHING);
    }
    return vec4f(rect.x + rect.z, rect.y + rect.w, size_of(rect), item_nearests[i]);
}

fn join_rects(a: vec4f, b: vec4f) -> vec4f {
    return vec4f(min(a.xy, b.xy), max(a.zw, b.zw));
}

// Halves each of the parts of `part` items.
fn halve_parts(lane: u32, part: u32) {
    let first = lane / part * part;
    let own = axis_keys(lane);
    var rank = vec4u(0u);
    for (var i = first; i < first + part; i++) {
        let other = axis_keys(i);
        let is_before = (other < own) | ((other == own) & vec4<bool>(i < lane));
        rank += select(vec4u(0u), vec4u(1u), is_before);
    }
    item_ranks[lane] = rank;
    workgroupBarrier();
    // A lane for each half of each part and axis.
    let parts = 64u / part;
    if lane < 2u * AXES * parts {
        let axis = lane / 2u % AXES;
        let side = lane % 2u;
        let begin = lane / (2u * AXES) * part;
        var rect = vec4f(NOTHING, NOTHING, -NOTHING, -NOTHING);
        for (var i = begin; i < begin + part; i++) {
            if (item_ranks[i][axis] >= part / 2u) == (side == 1u) {
                rect = join_rects(rect, item_rects[i]);
            }
        }
        half_sizes[lane] = size_of(rect);
    }
    workgroupBarrier();
    var best = 0u;
    var least = NOTHING;
    for (var axis = 0u; axis < AXES; axis++) {
        let at = 2u * (lane / part * AXES + axis);
        let size = half_sizes[at] + half_sizes[at + 1u];
        if size < least {
            least = size;
            best = axis;
        }
    }
    let to = first + item_ranks[lane][best];
    let rect = item_rects[lane];
    let nearest = item_nearests[lane];
    let number = item_numbers[lane];
    workgroupBarrier();
    item_rects[to] = rect;
    item_nearests[to] = nearest;
    item_numbers[to] = number;
    workgroupBarrier();
}

// Returns the exponent of the least power of two by which an extent has at most 126 steps, inverted.
fn inverse_exponent(extent: f32) -> u32 {
    let step = max(extent * (1.0 / 126.0), 1e-30);
    let exponent = (bitcast<u32>(step) + 0x7fffffu) >> 23u;
    return 254u - exponent;
}

const GUARD = 0x80u;

fn put_node(node: u32, first: u32) {
    var rect = vec4f(NOTHING, NOTHING, -NOTHING, -NOTHING);
    var nearest = NOTHING;
    var farthest = -NOTHING;
    for (var i = first; i < first + 8u; i++) {
        rect = join_rects(rect, item_rects[i]);
        nearest = min(nearest, item_nearests[i]);
        let is_there = item_rects[i].x <= item_rects[i].z;
        farthest = max(farthest, select(-NOTHING, item_nearests[i], is_there));
    }
    let exponents = vec3u(
        inverse_exponent(rect.z - rect.x),
        inverse_exponent(rect.w - rect.y),
        inverse_exponent(farthest - nearest),
    );
    let inverse = bitcast<vec3f>(exponents << vec3u(23u));
    var planes: array<vec2u, 5>;
    var children = vec2u(0u);
    for (var i = 0u; i < 8u; i++) {
        let item = item_rects[first + i];
        var low = vec3u(127u);
        var high = vec2u(0u);
        if item.x <= item.z {
            // A 32nd of a step is more than the rounding of differences.
            let steps = (vec3f(item.xy, item_nearests[first + i]) - vec3f(rect.xy, nearest)) * inverse;
            low = vec3u(clamp(floor(steps - 0.03125), vec3f(0.0), vec3f(127.0)));
            let ends = (item.zw - rect.xy) * inverse.xy;
            high = vec2u(clamp(ceil(ends + 0.03125), vec2f(0.0), vec2f(127.0)));
        }
        let word = i / 4u;
        let shift = 8u * (i % 4u);
        planes[0][word] |= low.x << shift;
        planes[1][word] |= (high.x | GUARD) << shift;
        planes[2][word] |= low.y << shift;
        planes[3][word] |= (high.y | GUARD) << shift;
        planes[4][word] |= low.z << shift;
        children[i / 5u] |= item_numbers[first + i] << (6u * (i % 5u));
    }
    let packed = exponents.x | (exponents.y << 8u) | (exponents.z << 16u);
    nodes[4u * node] = vec4u(bitcast<vec2u>(rect.xy), bitcast<u32>(nearest), packed);
    nodes[4u * node + 1u] = vec4u(planes[0], planes[1]);
    nodes[4u * node + 2u] = vec4u(planes[2], planes[3]);
    nodes[4u * node + 3u] = vec4u(planes[4], children);
    rects[node] = rect;
    nearests[node] = nearest;
}

fn build(block: u32, lane: u32) {
    workgroupBarrier();
    halve_parts(lane, 64u);
    halve_parts(lane, 32u);
    halve_parts(lane, 16u);
    let level = made.level + 1u;
    if lane < 8u && 8u * block + lane < count_at(level) {
        put_node(first_of(level) + 8u * block + lane, 8u * lane);
    }
}

fn clear_item(lane: u32) {
    item_rects[lane] = vec4f(NOTHING, NOTHING, -NOTHING, -NOTHING);
    item_nearests[lane] = NOTHING;
    item_numbers[lane] = lane;
}

@compute @workgroup_size(64)
fn build_leaves(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    clear_item(lane);
    let at = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if at < count_at(0u) {
        let reference = references[values[at]];
        let id = reference.x & 0x1fffffffu;
        ids[at] = id;
        if reference.y != 0xffffffffu {
            let face = reference.x >> 29u;
            let shape = shape_of(face, corners_of(id));
            let rect = rect_of(face, shape, reference.y & 0xffffu, reference.y >> 16u);
            if rect.is_there {
                item_rects[lane] = vec4f(rect.low, rect.high);
                item_nearests[lane] = rect.nearest;
            }
        }
    }
    build(group.x + GROUPS_A_ROW * group.y, lane);
}

@compute @workgroup_size(64)
fn build_nodes(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    clear_item(lane);
    let at = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    if at < count_at(made.level) {
        let node = first_of(made.level) + at;
        item_rects[lane] = rects[node];
        item_nearests[lane] = nearests[node];
    }
    build(group.x + GROUPS_A_ROW * group.y, lane);
}
