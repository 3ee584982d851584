// Returns the depth at a texel of the kernel's first image.

fn stored_depth(texel: vec2i, layer: i32) -> f32 {
    if IS_PACKED {
        return unpack_depth(load_0(texel, layer));
    }
    return load_0(texel, layer).x;
}
