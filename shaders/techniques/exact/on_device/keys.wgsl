// References to casters, and their keys: their place along a Hilbert curve over the light's view.

// Log2 of the number of steps of the curve along a side: 16 for a directional light, 14 for each
// face of a point light, whose keys begin with three bits of the face.
const SUN_CURVE_LOG2 = 16u;
const LAMP_CURVE_LOG2 = 14u;

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
    let log2 = select(SUN_CURVE_LOG2, LAMP_CURVE_LOG2, is_lamp());
    let half = select(max(view.face.y, view.face.z), 1.0, is_lamp());
    let shift = select(0.0, FACE_STEP * f32(face), is_lamp());
    let centre = (rect.low + rect.high) * 0.5 - vec2f(shift, 0.0);
    let steps = f32(1u << log2);
    let at = vec2u(clamp((centre + half) * (0.5 * steps / half), vec2f(0.0), vec2f(steps - 1.0)));
    return (face << (2u * log2)) | hilbert(at, log2);
}

// Writes a reference: its caster and face, and its piece and the number of pieces.
fn put_reference(at: u32, face: u32, id: u32, shape: Shape, number: u32, count: u32) {
    let rect = rect_of(face, shape, number, count);
    references[at] = vec2u(id | (face << 29u), number | (count << 16u));
    keys[at] = key_of(face % EVERYWHERE, rect);
}

fn put_nothing(at: u32) {
    references[at] = vec2u(NO_REFERENCE);
    keys[at] = NO_REFERENCE;
}

// Numbers of further references of a workgroup: `head`, without its first word.
var<workgroup> counted_here: array<atomic<u32>, 16>;

// Factor of counted ratios, so that the count is not too small if rounding differs in `make_keys`.
const COUNTED_RATIO = 1.0001;

// Counts the references of all casters, whole and at each step.
@compute @workgroup_size(64)
fn count_pieces(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let id = 64u * (group.x + groups.x * group.y) + lane;
    if id < made.casters {
        let corners = corners_of(id);
        var whole = 0u;
        for (var face = 0u; face < faces(); face++) {
            let shape = shape_of(face, corners);
            if !shape.is_there {
                continue;
            }
            whole += 1u;
            var ratio = COUNTED_RATIO * piece_ratio(shape);
            for (var step = 0u; step < STEPS && ratio >= 2.0; step++) {
                atomicAdd(&counted_here[1u + step], pieces_of(ratio) - 1u);
                ratio *= RATIO_STEP;
            }
        }
        if whole > 1u {
            atomicAdd(&counted_here[0], whole - 1u);
        }
    }
    workgroupBarrier();
    if lane <= STEPS {
        let count = atomicLoad(&counted_here[lane]);
        if count > 0u {
            atomicAdd(&head[MORE_WHOLE + lane], count);
        }
    }
}

// Returns the factor of ratios at the first step at which there are at most 1.8 references a
// caster, and at most the greatest number; 0 if there is none.
fn ratio_factor() -> f32 {
    let most = min(4u * made.casters / 5u, made.most_references - made.casters);
    let whole = atomicLoad(&head[MORE_WHOLE]);
    var factor = 1.0;
    for (var step = 0u; step < STEPS; step++) {
        if whole + atomicLoad(&head[MORE_PIECES + step]) <= most {
            return factor;
        }
        factor *= RATIO_STEP;
    }
    return 0.0;
}

var<workgroup> more_here: atomic<u32>;
var<workgroup> first_here: u32;

@compute @workgroup_size(64)
fn make_keys(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let id = 64u * (group.x + groups.x * group.y) + lane;
    let is_caster = id < made.casters;
    let factor = ratio_factor();
    var corners: array<vec3f, 3>;
    // Number of pieces on each face. It is computed once: drivers may round another computation
    // differently.
    var counts: array<u32, 6>;
    var wanted = 0u;
    if is_caster {
        corners = corners_of(id);
        for (var face = 0u; face < faces(); face++) {
            let shape = shape_of(face, corners);
            if shape.is_there {
                counts[face] = pieces_of(factor * piece_ratio(shape));
                wanted += counts[face];
            }
        }
    }
    // The first reference of a caster is at its number. Reserve the places of the others of this
    // workgroup at once.
    let more = max(wanted, 1u) - 1u;
    let own = atomicAdd(&more_here, more);
    workgroupBarrier();
    if lane == 0u {
        let count = atomicLoad(&more_here);
        if count > 0u {
            first_here = atomicAdd(&head[MORE], count);
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
    if end > made.most_references {
        // There are too many: keep a directional light's caster whole. One of a point light may
        // be anywhere.
        for (var i = begin; i < min(end, made.most_references); i++) {
            put_nothing(i);
        }
        let face = select(0u, EVERYWHERE, is_lamp());
        put_reference(id, face, id, shape_of(0u, corners), 0u, 1u);
        return;
    }
    var next = id;
    for (var face = 0u; face < faces(); face++) {
        let count = counts[face];
        if count == 0u {
            continue;
        }
        let shape = shape_of(face, corners);
        for (var i = 0u; i < count; i++) {
            put_reference(next, face, id, shape, i, count);
            next = select(next + 1u, begin, next == id);
        }
    }
}
