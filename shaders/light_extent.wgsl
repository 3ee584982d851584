// Twin of light_extent.rs: the light's half axes on the map, texels per unit of clip depth.

struct LightExtent {
    across: array<vec4f, 6>,
    along: array<vec4f, 6>,
}

fn light_axes(across: vec4f, along: vec4f, from_middle: vec2f) -> vec4f {
    let x = from_middle.x;
    let y = from_middle.y;
    if across.w > 0.0 {
        let tx = x * across.w;
        let ty = y * across.w;
        let a = sqrt(1.0 + tx * tx);
        let d = sqrt(1.0 + tx * tx + ty * ty);
        return vec4f(across.x * a, across.x * (tx * ty / a), 0.0, across.x * (d / a));
    }
    return vec4f(across.x + across.z * x, across.y + across.z * y, along.x + along.z * x, along.y + along.z * y);
}

fn reach_along(square: u32, axes: vec4f) -> vec2f {
    let a = axes * axes;
    let disc = vec2f(sqrt(a.x + a.z), sqrt(a.y + a.w));
    let b = abs(axes);
    return select(disc, vec2f(b.x + b.z, b.y + b.w), square != 0u);
}

fn texel_depth(reach: vec2f) -> f32 {
    return 1.0 / min(max(max(reach.x, reach.y), 1e-9), 1e9);
}
