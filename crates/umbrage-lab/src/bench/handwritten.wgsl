// A typical hand-written program for one technique: a depth pass, and 3x3 percentage-closer
// filtering with a slope bias.

struct Uniforms {
    clip_from_world: mat4x4f,
    to_light: vec3f,
    radius: i32,
}

@group(0) @binding(0) var<uniform> u: Uniforms;
@group(0) @binding(1) var shadow_map: texture_depth_2d;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;

@vertex fn draw_depth(@location(0) p: vec3f) -> @builtin(position) vec4f {
    return u.clip_from_world * vec4f(p, 1.0);
}

@vertex fn fullscreen(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0);
}

@fragment fn shade(@builtin(position) at: vec4f) -> @location(0) f32 {
    let pixel = vec2i(at.xy);
    let p = textureLoad(position, pixel, 0);
    if p.w == 0.0 {
        return 1.0;
    }
    let n = textureLoad(normal, pixel, 0).xyz;
    let clip = u.clip_from_world * vec4f(p.xyz, 1.0);
    let ndc = clip.xyz / clip.w;
    if ndc.z > 1.0 {
        return 1.0;
    }
    let size = vec2i(textureDimensions(shadow_map));
    let depth = ndc.z - max(0.05 * (1.0 - dot(n, u.to_light)), 0.005);
    let texel = vec2i(floor(vec2f(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2f(size)));
    var lit = 0.0;
    for (var dy = -u.radius; dy <= u.radius; dy++) {
        for (var dx = -u.radius; dx <= u.radius; dx++) {
            let at_texel = texel + vec2i(dx, dy);
            if any(at_texel < vec2i(0)) || any(at_texel >= size) {
                lit += 1.0;
            } else {
                lit += select(0.0, 1.0, depth <= textureLoad(shadow_map, at_texel, 0));
            }
        }
    }
    let side = f32(2 * u.radius + 1);
    return lit / (side * side);
}
