// Items of each cell's list.

// Words of an unsorted item: caster, box, least depth.
const UNSORTED = 3u;

fn fill_item(number: u32, id: u32, nearest: f32, touch: Touch, cell: vec2u) {
    if bitcast<u32>(nearest) > cover_of(number) {
        return;
    }
    // A cell has at least as many steps as a key.
    let shift = vec2u(STEPS - side_log2());
    let start = cell << shift;
    let key = shift - KEY_STEPS_LOG2;
    let low = (max(touch.low, start) - start) >> key;
    let high = (min(touch.high, start + (vec2u(1u) << shift) - 1u) - start) >> key;
    let bounds = low.x | (low.y << FIELD) | ((LAST - high.x) << (2u * FIELD)) | ((LAST - high.y) << (3u * FIELD));
    let left = atomicSub(&work[cell_word(number)], 1u);
    let first = tables[4u * (made.rows.y + number)];
    let word = UNSORTED * (first + left - 1u);
    unsorted[word] = id;
    unsorted[word + 1u] = bounds;
    unsorted[word + 2u] = bitcast<u32>(nearest);
}

// Box that contains no receiver: its least step is behind its greatest one.
const NOWHERE = LAST | (LAST << FIELD) | (LAST << (2u * FIELD)) | (LAST << (3u * FIELD));

// Sorts each cell's list by steps of depth. Items that were counted but not filled in are last, and
// match no receiver.
@compute @workgroup_size(64)
fn sort_items(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let cell = at.x + at.y * groups.x * 64u;
    if cell >= cell_count() || atomicLoad(&work[FITS]) == 0u {
        return;
    }
    let out = 4u * (made.rows.y + cell);
    let first = tables[out];
    let end = tables[out + 4u];
    // Lists were filled from their ends.
    let filled = first + atomicLoad(&work[cell_word(cell)]);
    var least = FAR;
    var greatest = 0u;
    for (var i = filled; i < end; i++) {
        let depth = unsorted[UNSORTED * i + 2u];
        least = min(least, depth);
        greatest = max(greatest, depth);
    }
    let nearest = bitcast<f32>(least);
    let width = bitcast<f32>(greatest) - nearest;
    var steps = 0.0;
    // Require a width that floats can resolve, so that the quotient is finite.
    if width > 1e-30 {
        steps = (KEY_STEPS - 1.0) / width;
    }
    tables[out + 2u] = least;
    tables[out + 3u] = bitcast<u32>(steps);
    var places: array<u32, 32>;
    for (var i = 0u; i < 32u; i++) {
        places[i] = 0u;
    }
    for (var i = filled; i < end; i++) {
        places[step_of(i, nearest, steps)] += 1u;
    }
    var next = first;
    for (var i = 0u; i < 32u; i++) {
        let count = places[i];
        places[i] = next;
        next += count;
    }
    for (var i = filled; i < end; i++) {
        let step = step_of(i, nearest, steps);
        let word = UNSORTED * i;
        put_item(places[step], vec2u(unsorted[word], unsorted[word + 1u] | (step << (4u * FIELD))));
        places[step] += 1u;
    }
    for (var i = next; i < end; i++) {
        put_item(i, vec2u(0u, NOWHERE | (LAST << (4u * FIELD))));
    }
}

// Returns the depth step of an unsorted item.
fn step_of(item: u32, nearest: f32, steps: f32) -> u32 {
    let depth = bitcast<f32>(unsorted[UNSORTED * item + 2u]);
    return u32(clamp((depth - nearest) * steps, 0.0, KEY_STEPS - 1.0));
}

fn put_item(place: u32, item: vec2u) {
    let word = 4u * made.rows.z + 2u * place;
    tables[word] = item.x;
    tables[word + 1u] = item.y;
}
