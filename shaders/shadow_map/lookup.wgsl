// Twin of lookup.rs: from a receiver to a texel of the map. `lookup_position` comes from offset.wgsl or
// no_offset.wgsl, `lookup_gradient` from plane.wgsl or no_plane.wgsl, `lookup_layer` and `lookup_face` from single.wgsl or
// cube.wgsl.

struct ShadowMapUniforms {
    layers: u32,
    packed: u32,
    clamped: u32,
    has_receiver_bias: u32,
    faces: array<mat4x4f, 6>,
    light: vec4f,
    farthest: f32,
    size: f32,
    texel: f32,
    constant: f32,
    slope: f32,
    slope_min: f32,
    normal_offset: f32,
    receiver_plane: f32,
    deepest_tap: f32,
    sample_gain: f32,
}

struct ShadowCoord {
    texel: vec2f,
    depth: f32,
    gradient: vec2f,
    deepest: f32,
    layer: i32,
    seen: bool,
}

fn to_light(light: vec4f, p: vec3f) -> vec3f {
    if light.w == 0.0 {
        return light.xyz;
    }
    return unit3(light.xyz - p);
}

fn slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32 {
    return max(slope * (1.0 - n_dot_l), least);
}

fn sine(cosine: f32) -> f32 {
    return sqrt(max(1.0 - cosine * cosine, 0.0));
}

fn texel_from_clip(clip: vec4f, size: f32) -> vec3f {
    let x = clip.x / clip.w;
    let y = clip.y / clip.w;
    let z = clip.z / clip.w;
    let u = (x * 0.5 + 0.5) * size;
    let v = (0.5 - y * 0.5) * size;
    return vec3f(max(min(u, 1e6), -1e6), max(min(v, 1e6), -1e6), z);
}

fn shadow_coord(m: ShadowMapUniforms, p: vec3f, n: vec3f) -> ShadowCoord {
    let layer = lookup_layer(m, p);
    let clip_from_world = lookup_face(m, layer);
    var p_offset = p;
    var bias = m.constant;
    if m.has_receiver_bias != 0u {
        let n_dot_l = dot3(n, to_light(m.light, p));
        bias += slope_bias(m.slope, m.slope_min, n_dot_l);
        p_offset = lookup_position(m, clip_from_world, p, n, n_dot_l);
    }
    let clip = transform(clip_from_world, p_offset);
    let t = texel_from_clip(clip, m.size);
    let gradient = lookup_gradient(m, clip_from_world, clip, n);
    let depth = t.z - bias;
    let deepest = max(depth, m.deepest_tap);
    let seen = clip.w > 0.0 && t.z <= m.farthest;
    return ShadowCoord(t.xy, depth, gradient, deepest, layer, seen);
}
