// Twin of light_extent.rs: the light's half axes on the map, texels per unit of clip depth.

struct LightExtent {
    half_axis_u: array<vec4f, 8>,
    half_axis_v: array<vec4f, 8>,
}

fn light_axes(half_axis_u: vec4f, half_axis_v: vec4f, from_middle: vec2f) -> vec4f {
    let x = from_middle.x;
    let y = from_middle.y;
    if half_axis_u.w > 0.0 {
        let tx = x * half_axis_u.w;
        let ty = y * half_axis_u.w;
        let a = sqrt(1.0 + tx * tx);
        let d = sqrt(1.0 + tx * tx + ty * ty);
        return vec4f(half_axis_u.x * a, half_axis_u.x * (tx * ty / a), 0.0, half_axis_u.x * (d / a));
    }
    return vec4f(half_axis_u.x + half_axis_u.z * x, half_axis_u.y + half_axis_u.z * y, half_axis_v.x + half_axis_v.z * x, half_axis_v.y + half_axis_v.z * y);
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
