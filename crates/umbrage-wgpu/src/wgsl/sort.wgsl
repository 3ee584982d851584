// A pass of a radix sort over a digit of 8 bits. It is stable: items of equal digits keep their
// order. Counts are stored digit by digit, so that their prefix sums are the digits' places.

struct SortPass {
    shift: u32,
    blocks: u32,
}

@group(0) @binding(0) var<uniform> digit_pass: SortPass;
@group(0) @binding(1) var<storage, read> head: array<u32>;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
@group(0) @binding(3) var<storage, read> values: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;
@group(0) @binding(6) var<storage, read_write> counts: array<u32>;

const BLOCK = 2048u;
const DIGITS = 256u;
// Words of a mask of 256 lanes.
const MASK = 8u;

var<workgroup> digit_counts: array<atomic<u32>, DIGITS>;
// For each digit, the lanes that have it.
var<workgroup> lanes_of: array<atomic<u32>, 2048>;
var<workgroup> places: array<u32, DIGITS>;

fn digit_of(key: u32) -> u32 {
    return (key >> digit_pass.shift) & (DIGITS - 1u);
}

@compute @workgroup_size(256)
fn count_digits(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let count = head[0];
    atomicStore(&digit_counts[lane], 0u);
    workgroupBarrier();
    for (var i = lane; i < BLOCK; i += 256u) {
        let item = BLOCK * group.x + i;
        if item < count {
            atomicAdd(&digit_counts[digit_of(keys[item])], 1u);
        }
    }
    workgroupBarrier();
    counts[lane * digit_pass.blocks + group.x] = atomicLoad(&digit_counts[lane]);
}

@compute @workgroup_size(256)
fn move_items(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let count = head[0];
    places[lane] = counts[lane * digit_pass.blocks + group.x];
    for (var i = 0u; i < MASK; i++) {
        atomicStore(&lanes_of[MASK * lane + i], 0u);
    }
    workgroupBarrier();
    for (var round = 0u; round < BLOCK / 256u; round++) {
        let item = BLOCK * group.x + 256u * round + lane;
        let is_item = item < count;
        var key = 0u;
        var digit = 0u;
        if is_item {
            key = keys[item];
            digit = digit_of(key);
            atomicOr(&lanes_of[MASK * digit + lane / 32u], 1u << (lane % 32u));
        }
        workgroupBarrier();
        // The rank among lanes of the same digit is the number of earlier ones.
        if is_item {
            var rank = places[digit];
            for (var i = 0u; i < lane / 32u; i++) {
                rank += countOneBits(atomicLoad(&lanes_of[MASK * digit + i]));
            }
            let own = atomicLoad(&lanes_of[MASK * digit + lane / 32u]);
            rank += countOneBits(own & ((1u << (lane % 32u)) - 1u));
            sorted_keys[rank] = key;
            sorted_values[rank] = values[item];
        }
        workgroupBarrier();
        var total = 0u;
        for (var i = 0u; i < MASK; i++) {
            total += countOneBits(atomicLoad(&lanes_of[MASK * lane + i]));
            atomicStore(&lanes_of[MASK * lane + i], 0u);
        }
        places[lane] += total;
        workgroupBarrier();
    }
}
