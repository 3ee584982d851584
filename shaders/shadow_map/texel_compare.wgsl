// Twin of texel_compare.rs: the comparison with one texel of the kernel's first image. `depth_at`, `stored_depth` and `tap_outside`
// are this map's choices (see choices.rs) among the variants below.

// Where the receiver's plane is followed.
fn depth_at_on_plane(l: ShadowCoord, x: i32, y: i32) -> f32 {
    return depth_on_plane(l.depth, l.gradient, l.deepest, l.texel, x, y);
}

// Where it is not: one depth for all taps.
fn depth_at_receiver(l: ShadowCoord, x: i32, y: i32) -> f32 {
    return l.depth;
}

// Beside the map everything is lit.
fn tap_outside_lit(size: i32, l: ShadowCoord, x: i32, y: i32) -> f32 {
    return 1.0;
}

// Beside the map its edge repeats.
fn tap_outside_clamped(size: i32, l: ShadowCoord, x: i32, y: i32) -> f32 {
    let texel = vec2i(clamp(x, 0, size - 1), clamp(y, 0, size - 1));
    return select(0.0, 1.0, depth_at(l, x, y) <= stored_depth(texel, l.layer));
}

fn tap(size: i32, l: ShadowCoord, x: i32, y: i32) -> f32 {
    if x < 0 || y < 0 || x >= size || y >= size {
        return tap_outside(size, l, x, y);
    }
    return select(0.0, 1.0, depth_at(l, x, y) <= stored_depth(vec2i(x, y), l.layer));
}
