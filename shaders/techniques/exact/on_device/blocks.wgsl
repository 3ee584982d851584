// Nodes of a hierarchy of 8 children. A workgroup takes 64 neighbours along the curve and divides
// them into 8 groups of 8: three times into halves, by the key with the smallest halves. nodes.wgsl
// defines `keys_of`, `size_of`, `load_reference` and `put_node`.

// Number of keys by which parts are halved.
const AXES = 4u;

// Beyond all coordinates.
const BEYOND = 3e38;

var<workgroup> lows: array<vec3f, 64>;
var<workgroup> highs: array<vec3f, 64>;
var<workgroup> item_numbers: array<u32, 64>;
var<workgroup> item_ranks: array<vec4u, 64>;
// Size of each half of each part across each axis.
var<workgroup> half_sizes: array<f32, 32>;

// Returns the number of nodes of a level, at least one; of references at level 0.
fn count_at(level: u32) -> u32 {
    var count = min(made.casters + atomicLoad(&head[MORE]), made.most_references);
    for (var i = 0u; i < level; i++) {
        count = max((count + 7u) / 8u, 1u);
    }
    return count;
}

fn is_item(i: u32) -> bool {
    return lows[i].x <= highs[i].x;
}

// Halves each of the parts of `part` items.
fn halve_parts(lane: u32, part: u32) {
    let first = lane / part * part;
    let own = keys_of(lane);
    var rank = vec4u(0u);
    for (var i = first; i < first + part; i++) {
        let other = keys_of(i);
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
        var low = vec3f(BEYOND);
        var high = vec3f(-BEYOND);
        for (var i = begin; i < begin + part; i++) {
            if (item_ranks[i][axis] >= part / 2u) == (side == 1u) {
                low = min(low, lows[i]);
                high = max(high, highs[i]);
            }
        }
        half_sizes[lane] = size_of(low, high);
    }
    workgroupBarrier();
    var best = 0u;
    var least = BEYOND;
    for (var axis = 0u; axis < AXES; axis++) {
        let at = 2u * (lane / part * AXES + axis);
        let size = half_sizes[at] + half_sizes[at + 1u];
        if size < least {
            least = size;
            best = axis;
        }
    }
    let to = first + item_ranks[lane][best];
    let low = lows[lane];
    let high = highs[lane];
    let number = item_numbers[lane];
    workgroupBarrier();
    lows[to] = low;
    highs[to] = high;
    item_numbers[to] = number;
    workgroupBarrier();
}

fn build(block: u32, lane: u32) {
    workgroupBarrier();
    halve_parts(lane, 64u);
    halve_parts(lane, 32u);
    halve_parts(lane, 16u);
    let level = made.level + 1u;
    if lane < 8u && 8u * block + lane < count_at(level) {
        let first = 8u * lane;
        var low = vec3f(BEYOND);
        var high = vec3f(-BEYOND);
        for (var i = first; i < first + 8u; i++) {
            low = min(low, lows[i]);
            high = max(high, highs[i]);
        }
        let node = first_of(level) + 8u * block + lane;
        let stored = put_node(node, first, low, high);
        boxes[2u * node] = vec4f(low, 0.0);
        boxes[2u * node + 1u] = vec4f(stored, 0.0);
    }
}

fn clear_item(lane: u32) {
    lows[lane] = vec3f(BEYOND);
    highs[lane] = vec3f(-BEYOND);
    item_numbers[lane] = lane;
}

@compute @workgroup_size(64)
fn build_leaves(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group.x + groups.x * group.y;
    clear_item(lane);
    let at = 64u * block + lane;
    if at < count_at(0u) {
        load_reference(at, lane);
    }
    build(block, lane);
    // Write the header.
    if at == 0u {
        put_row(made.nodes, vec4u(made.levels, made.ids - made.nodes, count_at(0u), 0u));
        for (var i = 0u; i < 3u; i++) {
            put_row(made.nodes + 1u + i, made.firsts[i]);
        }
    }
}

@compute @workgroup_size(64)
fn build_nodes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group.x + groups.x * group.y;
    clear_item(lane);
    let at = 64u * block + lane;
    if at < count_at(made.level) {
        let node = first_of(made.level) + at;
        lows[lane] = boxes[2u * node].xyz;
        highs[lane] = boxes[2u * node + 1u].xyz;
    }
    build(block, lane);
}

// Returns the exponent of the least power of two by which an extent has at most 126 steps, inverted.
fn inverse_exponent(extent: f32) -> u32 {
    let step = max(extent * (1.0 / 126.0), 1e-30);
    let exponent = (bitcast<u32>(step) + 0x7fffffu) >> 23u;
    return 254u - exponent;
}
