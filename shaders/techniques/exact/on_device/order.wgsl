// Start of each cell's list.

var<workgroup> sums: array<u32, 256>;

// Returns the sum of the values of the lanes before this one. The total is the last lane's sum plus
// its own value.
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

fn items_of(cell: u32) -> u32 {
    if cell >= cell_count() {
        return 0u;
    }
    return atomicLoad(&work[cell_word(cell)]);
}

// Returns the numbers of items of four cells.
fn items_of_four(first: u32) -> vec4u {
    return vec4u(items_of(first), items_of(first + 1u), items_of(first + 2u), items_of(first + 3u));
}

@compute @workgroup_size(256)
fn sum_blocks(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let counts = items_of_four(BLOCK * group.x + 4u * lane);
    let own = counts.x + counts.y + counts.z + counts.w;
    let earlier = sum_before(lane, own);
    if lane == 255u && group.x < blocks() {
        atomicStore(&work[HEAD + group.x], earlier + own);
    }
}

// Number of workgroups for each pass of a further attempt.
@group(1) @binding(0) var<storage, read_write> further: array<u32>;

// Converts the blocks' sums to prefix sums, and records whether the lists fit. If they do, further
// attempts have no workgroups. Otherwise cells become twice as wide.
@compute @workgroup_size(256)
fn sum_all(@builtin(local_invocation_index) lane: u32) {
    let is_done = atomicLoad(&work[FITS]) != 0u;
    let each = (blocks() + 255u) / 256u;
    let first = min(each * lane, blocks());
    let end = min(first + each, blocks());
    var own = 0u;
    for (var i = first; i < end; i++) {
        own += atomicLoad(&work[HEAD + i]);
    }
    var earlier = sum_before(lane, own);
    if is_done {
        return;
    }
    let total = earlier + own;
    for (var i = first; i < end; i++) {
        let block = atomicLoad(&work[HEAD + i]);
        atomicStore(&work[HEAD + i], earlier);
        earlier += block;
    }
    if lane != 255u {
        return;
    }
    if atomicLoad(&work[NEEDED]) == 0u {
        atomicStore(&work[NEEDED], total);
    }
    if total <= made.items && touches_fit() {
        atomicStore(&work[TOTAL], total);
        atomicStore(&work[FITS], 1u);
        for (var i = 0u; i < arrayLength(&further); i++) {
            further[i] = 0u;
        }
    } else {
        atomicAdd(&work[HALVED], 1u);
    }
}

@compute @workgroup_size(256)
fn place_cells(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = BLOCK * group.x + 4u * lane;
    let fits = atomicLoad(&work[FITS]) != 0u;
    let counts = select(vec4u(0u), items_of_four(first), fits);
    var place = sum_before(lane, counts.x + counts.y + counts.z + counts.w);
    if fits && group.x < blocks() {
        place += atomicLoad(&work[HEAD + group.x]);
    }
    for (var i = 0u; i < 4u; i++) {
        place_cell(first + i, place, fits);
        place += counts[i];
        place_tile(first + i);
    }
}

// If nothing fits, all lists are empty and nothing casts.
fn place_cell(cell: u32, first_item: u32, fits: bool) {
    let out = 4u * (made.rows.y + cell);
    if cell == cell_count() {
        tables[out] = select(0u, atomicLoad(&work[TOTAL]), fits);
    }
    if cell >= cell_count() {
        return;
    }
    tables[out] = first_item;
    tables[out + 1u] = select(FAR, cover_of(cell), fits);
    // An absent item has no nearest depth.
    tables[out + 2u] = FAR;
    tables[out + 3u] = 0u;
}

fn place_tile(tile: u32) {
    if tile >= tile_count() {
        return;
    }
    let out = 4u * made.rows.x + 2u * tile;
    tables[out] = tile << (2u * side_log2());
    tables[out + 1u] = side_log2();
}
