// Twin of `MomentsKernel` in of_depth.rs. Which moments, is the kernel's choice.

struct MomentsUniforms {
    channels: u32,
    rising: f32,
    falling: f32,
}

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    return stored_moments(moments_of(stored_depth(texel, layer)));
}
