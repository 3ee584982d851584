// Twin of evsm.rs: the bounds by exponentials of depth. `lit_by_moments` is the kernel's choice between these.

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

fn lit_by_two(moments: vec4f, depth: f32) -> f32 {
    let receiver = power_of_two(kernel.rising * depth);
    return lit_by_rising(moments.xy, receiver, kernel.least_rising);
}

fn lit_by_both(moments: vec4f, depth: f32) -> f32 {
    let receiver = power_of_two(-(kernel.falling * depth));
    let lit = lit_by_falling(moments.zw, receiver, kernel.least_falling);
    return min(lit_by_two(moments, depth), lit);
}
