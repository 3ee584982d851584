// The map's depth at a texel. In place of stored_packed.wgsl where it is stored as it is.

fn stored_depth(texel: vec2i, layer: i32) -> f32 {
    return load_0(texel, layer).x;
}
