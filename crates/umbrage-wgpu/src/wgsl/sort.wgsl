// A pass of a radix sort over a digit of 8 bits, which sorts the numbers of items by their keys. It
// is stable: items of equal digits keep their order. Counts are stored digit by digit, so that their
// prefix sums are the digits' places.
//
// Prefix sums: blocks of 1,024 counts are summed, one workgroup sums the blocks, and each count
// becomes the sum of those before it.

struct SortPass {
    shift: u32,
    // Number of blocks of items, and of blocks of counts.
    blocks: u32,
    sum_blocks: u32,
    // Number of items that `head` doesn't count, and the greatest number of all.
    first: u32,
    most: u32,
}

@group(0) @binding(0) var<uniform> digit_pass: SortPass;
@group(0) @binding(1) var<storage, read> head: array<u32>;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
@group(0) @binding(3) var<storage, read> numbers: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_numbers: array<u32>;
@group(0) @binding(6) var<storage, read_write> counts: array<u32>;
@group(0) @binding(7) var<storage, read_write> block_sums: array<u32>;

const BLOCK = 2048u;
const DIGITS = 256u;
const SUM_BLOCK = 1024u;
// Shift of the last pass.
const LAST_SHIFT = 24u;
// Words of a mask of 256 lanes.
const MASK = 8u;

var<workgroup> digit_counts: array<atomic<u32>, DIGITS>;
// For each digit, the lanes that have it.
var<workgroup> lanes_of: array<atomic<u32>, 2048>;
var<workgroup> places: array<u32, DIGITS>;

fn item_count() -> u32 {
    return min(digit_pass.first + head[0], digit_pass.most);
}

fn digit_of(key: u32) -> u32 {
    return (key >> digit_pass.shift) & (DIGITS - 1u);
}

@compute @workgroup_size(256)
fn count_digits(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let count = item_count();
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
    let count = item_count();
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
            // The first pass has the items in their order, and nothing reads the keys of the last.
            var number = item;
            if digit_pass.shift > 0u {
                number = numbers[item];
            }
            sorted_numbers[rank] = number;
            if digit_pass.shift < LAST_SHIFT {
                sorted_keys[rank] = key;
            }
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

var<workgroup> sums: array<u32, 256>;

// Returns the sum of the values of the lanes before this one.
fn sum_before(lane: u32, value: u32) -> u32 {
    sums[lane] = value;
    workgroupBarrier();
    for (var step = 1u; step < 256u; step *= 2u) {
        var other = 0u;
        if lane >= step {
            other = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += other;
        workgroupBarrier();
    }
    return sums[lane] - value;
}

fn count_at(i: u32) -> u32 {
    if i >= DIGITS * digit_pass.blocks {
        return 0u;
    }
    return counts[i];
}

@compute @workgroup_size(256)
fn sum_counts(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = SUM_BLOCK * group.x + 4u * lane;
    let own = count_at(first) + count_at(first + 1u) + count_at(first + 2u) + count_at(first + 3u);
    let before = sum_before(lane, own);
    if lane == 255u {
        block_sums[group.x] = before + own;
    }
}

@compute @workgroup_size(256)
fn sum_all(@builtin(local_invocation_index) lane: u32) {
    let each = (digit_pass.sum_blocks + 255u) / 256u;
    let first = min(each * lane, digit_pass.sum_blocks);
    let end = min(first + each, digit_pass.sum_blocks);
    var own = 0u;
    for (var i = first; i < end; i++) {
        own += block_sums[i];
    }
    var before = sum_before(lane, own);
    for (var i = first; i < end; i++) {
        let block = block_sums[i];
        block_sums[i] = before;
        before += block;
    }
}

@compute @workgroup_size(256)
fn place_counts(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = SUM_BLOCK * group.x + 4u * lane;
    let own = vec4u(count_at(first), count_at(first + 1u), count_at(first + 2u), count_at(first + 3u));
    var before = block_sums[group.x] + sum_before(lane, own.x + own.y + own.z + own.w);
    for (var i = 0u; i < 4u; i++) {
        if first + i < DIGITS * digit_pass.blocks {
            counts[first + i] = before;
        }
        before += own[i];
    }
}
