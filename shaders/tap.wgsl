// Twin of `tap` in shadow_map.rs. Its own module, since it reads the kernel's first image.

fn tap(size: i32, l: Lookup, x: i32, y: i32) -> f32 {
    if x < 0 || y < 0 || x >= size || y >= size {
        return 1.0;
    }
    return select(0.0, 1.0, depth_at(l, x, y) <= load_0(vec2i(x, y), 0).x);
}
