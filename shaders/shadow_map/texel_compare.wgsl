// Twin of texel_compare.rs: the comparison with one texel of the kernel's first image.

fn depth_at(l: ShadowCoord, x: i32, y: i32) -> f32 {
    if TAPS_FOLLOW_PLANE {
        return depth_on_plane(l.depth, l.gradient, l.deepest, l.texel, x, y);
    }
    return own_depth(l);
}

fn is_lit_outside(is_outside: bool) -> bool {
    if EDGE_REPEATS {
        return false;
    }
    return is_outside;
}

fn tap(size: i32, l: ShadowCoord, x: i32, y: i32) -> f32 {
    let at = vec2i(x, y);
    // Load in any case, to avoid a branch per tap.
    let nearest = clamp(at, vec2i(0), vec2i(size - 1));
    let is_lit = depth_at(l, x, y) <= stored_depth(nearest, l.layer);
    return select(0.0, 1.0, is_lit | is_lit_outside(any(at != nearest)));
}
