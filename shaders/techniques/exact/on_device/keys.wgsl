// Keys of casters: their place along a Hilbert curve over the light's view.

// Log2 of the number of steps of the curve along a side: 14 for a directional light, 13 for each
// face of a point light.
const CURVE_LOG2 = 14u;

// Returns the place of a point along a Hilbert curve (Hilbert 1891) through 2^log2 x 2^log2 points.
fn hilbert(at: vec2u, log2: u32) -> u32 {
    var p = at;
    var place = 0u;
    for (var i = 0u; i < log2; i++) {
        let s = 1u << (log2 - 1u - i);
        let r = vec2u(select(0u, 1u, (p.x & s) != 0u), select(0u, 1u, (p.y & s) != 0u));
        place = 4u * place + ((3u * r.x) ^ r.y);
        if r.y == 0u {
            if r.x == 1u {
                p = vec2u(s - 1u) - (p & vec2u(s - 1u));
            }
            p = p.yx;
        }
        p &= vec2u(s - 1u);
    }
    return place;
}

fn key_of(face: u32, rect: Rect) -> u32 {
    let log2 = select(CURVE_LOG2, CURVE_LOG2 - 1u, is_lamp());
    let half = select(max(grid.face.x, grid.face.y), 1.0, is_lamp());
    let shift = select(0.0, FACE_STEP * f32(face), is_lamp());
    let middle = (rect.low + rect.high) * 0.5 - vec2f(shift, 0.0);
    let steps = f32(1u << log2);
    let at = vec2u(clamp((middle + half) * (0.5 * steps / half), vec2f(0.0), vec2f(steps - 1.0)));
    return (face << (2u * log2)) | hilbert(at, log2);
}

// Writes a reference: its caster and face, and its piece and the number of pieces.
fn put_reference(at: u32, face: u32, id: u32, shape: Shape, number: u32, count: u32) {
    let rect = rect_of(face, shape, number, count);
    references[at] = vec2u(id | (face << 29u), number | (count << 16u));
    values[at] = at;
    keys[at] = key_of(face % EVERYWHERE, rect);
}

fn put_nothing(at: u32) {
    references[at] = vec2u(NO_REFERENCE);
    values[at] = at;
    keys[at] = NO_REFERENCE;
}

var<workgroup> here: atomic<u32>;
var<workgroup> first_here: u32;

@compute @workgroup_size(64)
fn make_keys(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let id = 64u * (group.x + GROUPS_A_ROW * group.y) + lane;
    let is_caster = id < made.casters;
    var corners: array<vec3f, 3>;
    var wanted = 0u;
    if is_caster {
        corners = corners_of(id);
        for (var face = 0u; face < faces(); face++) {
            let shape = shape_of(face, corners);
            if shape.is_there {
                wanted += pieces_of(shape);
            }
        }
    }
    // The first reference of a caster is at its number. Reserve the places of the others of this
    // workgroup at once.
    let more = max(wanted, 1u) - 1u;
    let own = atomicAdd(&here, more);
    workgroupBarrier();
    if lane == 0u {
        let count = atomicLoad(&here);
        if count > 0u {
            first_here = atomicAdd(&head[1], count);
        }
    }
    workgroupBarrier();
    if !is_caster {
        return;
    }
    let begin = made.casters + first_here + own;
    let end = begin + more;
    if wanted == 0u {
        put_nothing(id);
        return;
    }
    if end > made.capacity {
        // There is no capacity: the caster may be anywhere.
        for (var i = begin; i < min(end, made.capacity); i++) {
            put_nothing(i);
        }
        var shape: Shape;
        if is_lamp() {
            put_reference(id, EVERYWHERE, id, shape, 0u, 1u);
        } else {
            put_reference(id, 0u, id, shape_of(0u, corners), 0u, 1u);
        }
        return;
    }
    var next = id;
    for (var face = 0u; face < faces(); face++) {
        let shape = shape_of(face, corners);
        if !shape.is_there {
            continue;
        }
        let count = pieces_of(shape);
        for (var i = 0u; i < count; i++) {
            put_reference(next, face, id, shape, i, count);
            next = select(next + 1u, begin, next == id);
        }
    }
}

@compute @workgroup_size(1)
fn count_references() {
    atomicStore(&head[0], min(made.casters + atomicLoad(&head[1]), made.capacity));
    // Write the header that receivers read.
    put_row(made.nodes, vec4u(made.levels, 0u, 0u, 0u));
    for (var i = 0u; i < 3u; i++) {
        put_row(made.nodes + 1u + i, made.firsts[i]);
    }
}
