// Prefix sums: each word becomes the sum of the words before it. Blocks of 1024 words are summed,
// one workgroup sums the blocks, and the sums are distributed.

struct ScanPlace {
    words: u32,
    blocks: u32,
}

@group(0) @binding(0) var<uniform> scan: ScanPlace;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> block_sums: array<u32>;

const BLOCK = 1024u;

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

fn word_at(i: u32) -> u32 {
    if i >= scan.words {
        return 0u;
    }
    return words[i];
}

@compute @workgroup_size(256)
fn sum_blocks(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = BLOCK * group.x + 4u * lane;
    let own = word_at(first) + word_at(first + 1u) + word_at(first + 2u) + word_at(first + 3u);
    let before = sum_before(lane, own);
    if lane == 255u {
        block_sums[group.x] = before + own;
    }
}

@compute @workgroup_size(256)
fn sum_all(@builtin(local_invocation_index) lane: u32) {
    let each = (scan.blocks + 255u) / 256u;
    let first = min(each * lane, scan.blocks);
    let end = min(first + each, scan.blocks);
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
    if lane == 255u {
        block_sums[scan.blocks] = before;
    }
}

@compute @workgroup_size(256)
fn place_all(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = BLOCK * group.x + 4u * lane;
    let own = vec4u(word_at(first), word_at(first + 1u), word_at(first + 2u), word_at(first + 3u));
    var before = block_sums[group.x] + sum_before(lane, own.x + own.y + own.z + own.w);
    for (var i = 0u; i < 4u; i++) {
        if first + i < scan.words {
            words[first + i] = before;
        }
        before += own[i];
    }
}
