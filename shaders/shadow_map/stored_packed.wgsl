// In place of stored.wgsl where depth is packed into four channels.

fn stored_depth(texel: vec2i, layer: i32) -> f32 {
    return unpack_depth(load_0(texel, layer));
}
