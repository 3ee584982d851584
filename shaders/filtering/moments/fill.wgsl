// Twin of `MomentsKernel` in of_depth.rs.

// Values of `MOMENTS`: see of_depth.rs.
const VARIANCE = 0u;
const EXPONENTIALS = 1u;
const POWERS = 2u;

struct MomentsUniforms {
    rising: f32,
    falling: f32,
}

fn moments_of(depth: f32) -> vec4f {
    if MOMENTS == VARIANCE {
        return vec4f(variance_moments(depth), 0.0, 0.0);
    }
    if MOMENTS == EXPONENTIALS {
        return exponential_moments(depth, kernel.rising, kernel.falling);
    }
    return power_moments(depth);
}

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    return stored_moments(moments_of(stored_depth(texel, layer)));
}
