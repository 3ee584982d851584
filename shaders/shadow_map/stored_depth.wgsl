// The depth at a texel of the kernel's first image. `stored_depth` is the map's choice (see choices.rs) between these.

// Depth that is stored as it is.
fn stored_depth_plain(texel: vec2i, layer: i32) -> f32 {
    return load_0(texel, layer).x;
}

// Depth in four channels.
fn stored_depth_packed(texel: vec2i, layer: i32) -> f32 {
    return unpack_depth(load_0(texel, layer));
}
