// Twin of evsm.rs: the bounds from exponentials of depth.

struct EvsmUniforms {
    lookup: ShadowMapUniforms,
    mipmaps: MipmapUniforms,
    bleeding: f32,
    bleeding_scale: f32,
    rising: f32,
    falling: f32,
    least_rising: f32,
    least_falling: f32,
}

fn compared_depth(l: ShadowCoord, spread: f32) -> f32 {
    return l.depth;
}

fn lit_by_moments(moments: vec4f, depth: f32) -> f32 {
    let rising = power_of_two(kernel.rising * depth);
    let lit = lit_by_rising(moments.xy, rising, kernel.least_rising);
    if !HAS_FOUR_MOMENTS {
        return lit;
    }
    let falling = power_of_two(-(kernel.falling * depth));
    return min(lit, lit_by_falling(moments.zw, falling, kernel.least_falling));
}
