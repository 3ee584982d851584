// Keys of casters: their place along a Hilbert curve through the world.

struct TreePlace {
    casters: u32,
    capacity: u32,
    levels: u32,
    level: u32,
    firsts: array<vec4u, 3>,
}

@group(0) @binding(1) var<uniform> made: TreePlace;
@group(0) @binding(2) var<storage, read> corners: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> keys: array<u32>;
@group(0) @binding(4) var<storage, read_write> values: array<u32>;
@group(0) @binding(5) var<storage, read_write> head: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> references: array<vec2u>;

const BITS = 10u;
const NOTHING = 0xffffffffu;

// Returns the place of a point along a Hilbert curve (Skilling 2004, "Programming the Hilbert
// curve").
fn hilbert3(p: vec3u) -> u32 {
    var x = array<u32, 3>(p.x, p.y, p.z);
    for (var b = BITS - 1u; b > 0u; b--) {
        let q = 1u << b;
        let mask = q - 1u;
        for (var i = 0u; i < 3u; i++) {
            if (x[i] & q) != 0u {
                x[0] ^= mask;
            } else {
                let t = (x[0] ^ x[i]) & mask;
                x[0] ^= t;
                x[i] ^= t;
            }
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    var t = 0u;
    for (var b = BITS - 1u; b > 0u; b--) {
        if (x[2] & (1u << b)) != 0u {
            t ^= (1u << b) - 1u;
        }
    }
    var place = 0u;
    for (var b = 0u; b < BITS; b++) {
        let bit = BITS - 1u - b;
        for (var i = 0u; i < 3u; i++) {
            place = 2u * place + (((x[i] ^ t) >> bit) & 1u);
        }
    }
    return place;
}

fn put_reference(at: u32, id: u32, points: array<vec3f, 3>, number: u32, count: u32) {
    let part = piece_of(points, number, count);
    let size = max(world.high.xyz - world.low.xyz, vec3f(1e-20));
    let steps = f32(1u << BITS);
    let middle = ((part.low + part.high) * 0.5 - world.low.xyz) / size * steps;
    references[at] = vec2u(id, number | (count << 16u));
    values[at] = at;
    keys[at] = hilbert3(vec3u(clamp(middle, vec3f(0.0), vec3f(steps - 1.0))));
}

var<workgroup> here: atomic<u32>;
var<workgroup> first_here: u32;

@compute @workgroup_size(64)
fn make_keys(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let id = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    let is_caster = id < made.casters;
    var points: array<vec3f, 3>;
    var count = 1u;
    if is_caster {
        points = corners_of(id);
        count = pieces_of(points);
    }
    let own = atomicAdd(&here, count - 1u);
    workgroupBarrier();
    if lane == 0u {
        first_here = atomicAdd(&head[1], atomicLoad(&here));
    }
    workgroupBarrier();
    if !is_caster {
        return;
    }
    let begin = made.casters + first_here + own;
    let end = begin + count - 1u;
    if end > made.capacity {
        // There is no capacity: the caster is not divided.
        for (var i = begin; i < min(end, made.capacity); i++) {
            references[i] = vec2u(NOTHING);
            values[i] = i;
            keys[i] = NOTHING;
        }
        put_reference(id, id, points, 0u, 1u);
        return;
    }
    for (var i = 0u; i < count; i++) {
        put_reference(select(begin + i - 1u, id, i == 0u), id, points, i, count);
    }
}

@compute @workgroup_size(1)
fn count_references() {
    atomicStore(&head[0], min(made.casters + atomicLoad(&head[1]), made.capacity));
}
