// Twin of msm.rs: the bounds from four powers of depth.

struct MsmUniforms {
    lookup: ShadowMapUniforms,
    mipmaps: MipmapUniforms,
    bleeding: f32,
    bleeding_scale: f32,
    moment_bias: f32,
    plane_deviation: f32,
}

fn spread_deviation(deviation: f32, spread: f32) -> f32 {
    if spread > 0.0 {
        return sqrt(deviation * deviation + spread);
    }
    return deviation;
}

fn compared_depth(l: ShadowCoord, spread: f32) -> f32 {
    let slope = sqrt(l.gradient.x * l.gradient.x + l.gradient.y * l.gradient.y);
    return l.depth - spread_deviation(kernel.plane_deviation, spread) * slope;
}

// Returns the moments mixed with those of a distribution whose depths are far apart.
fn biased_moments(moments: vec4f) -> vec4f {
    return moments + (vec4f(0.0, 0.375, 0.0, 0.375) - moments) * kernel.moment_bias;
}

fn lit_by_moments(moments: vec4f, depth: f32) -> f32 {
    if IS_HAUSDORFF {
        return hausdorff(biased_moments(moments), depth);
    }
    return hamburger(biased_moments(moments), depth);
}
