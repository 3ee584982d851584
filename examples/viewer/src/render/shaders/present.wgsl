// The image in the window. `ENCODES` precedes this text: whether the window's format encodes
// colours.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) uv: vec2f,
}

@vertex fn place(@builtin(vertex_index) i: u32) -> Corner {
    let uv = vec2f(f32(i & 1u), f32((i >> 1u) & 1u));
    return Corner(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), uv);
}

fn decoded(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

@fragment fn shade(seen: Corner) -> @location(0) vec4f {
    let color = textureSample(picture, picture_sampler, seen.uv).xyz;
    if ENCODES {
        return vec4f(decoded(color), 1.0);
    }
    return vec4f(color, 1.0);
}
