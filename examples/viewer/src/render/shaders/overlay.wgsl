// An overlay of the image.

struct Cover {
    // x, y: start and end of the covered part, as fractions of the width; z: opacity.
    part: vec4f,
}
@group(0) @binding(0) var<uniform> cover: Cover;
@group(0) @binding(1) var figures: texture_2d<f32>;

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) uv: vec2f,
}

@vertex fn place(@builtin(vertex_index) i: u32) -> Corner {
    let uv = vec2f(mix(cover.part.x, cover.part.y, f32(i & 1u)), f32((i >> 1u) & 1u));
    return Corner(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), uv);
}

@fragment fn shade(seen: Corner) -> @location(0) vec4f {
    let size = vec2i(textureDimensions(figures));
    let texel = clamp(vec2i(seen.uv * vec2f(size)), vec2i(0), size - 1);
    let color = textureLoad(figures, texel, 0);
    return vec4f(color.xyz, color.w * cover.part.z);
}
