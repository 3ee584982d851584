// Twin of `tap` in lookup.rs. Its own module, since it reads the kernel's first image.

fn tap(size: i32, l: ShadowCoord, x: i32, y: i32) -> f32 {
    if x < 0 || y < 0 || x >= size || y >= size {
        return tap_outside(size, l, x, y);
    }
    return select(0.0, 1.0, depth_at(l, x, y) <= stored_depth(vec2i(x, y), l.layer));
}
