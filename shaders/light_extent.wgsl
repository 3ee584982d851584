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
