// Twin of pattern_taps.rs: the kernel's first table holds the taps of its sets, then the turns.

fn pattern_row(i: u32) -> vec4f {
    return bitcast<vec4f>(table_0[i]);
}

// Returns the depth stored at a position (x) and the receiver's depth there (y). Outside the map
// nothing is nearer, unless its edge repeats.
fn place_depths(l: ShadowCoord, size: i32, at: vec2f) -> vec2f {
    let x = i32(floor(at.x));
    let y = i32(floor(at.y));
    let receiver = depth_at(l, x, y);
    let texel = vec2i(clamp(x, 0, size - 1), clamp(y, 0, size - 1));
    if !EDGE_REPEATS && (texel.x != x || texel.y != y) {
        return vec2f(2.0, receiver);
    }
    return vec2f(stored_depth(texel, l.layer), receiver);
}

fn lit_taps(l: ShadowCoord, size: i32, axes: vec4f, first: u32, count: u32, shift: vec2f) -> i32 {
    var lit = 0;
    for (var tap = first; tap < first + count; tap++) {
        let d = place_depths(l, size, tap_place(l.texel, axes, pattern_row(tap).xy, shift));
        lit += select(0, 1, d.y <= d.x);
    }
    return lit;
}
