// Twin of vsm.rs: the bound from the mean of depth and of its square.

struct VsmUniforms {
    lookup: ShadowMapUniforms,
    mipmaps: MipmapUniforms,
    bleeding: f32,
    bleeding_scale: f32,
    least_variance: f32,
}

fn compared_depth(l: ShadowCoord, spread: f32) -> f32 {
    return l.depth;
}

fn lit_by_moments(moments: vec4f, depth: f32) -> f32 {
    return lit_by_variance(moments.xy, depth, kernel.least_variance);
}
