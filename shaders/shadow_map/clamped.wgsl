// Beside the map, its edge repeats.

fn tap_outside(size: i32, l: ShadowCoord, x: i32, y: i32) -> f32 {
    let texel = vec2i(clamp(x, 0, size - 1), clamp(y, 0, size - 1));
    return select(0.0, 1.0, depth_at(l, x, y) <= stored_depth(texel, l.layer));
}
