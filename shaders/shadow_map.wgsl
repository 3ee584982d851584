// Twin of shadow_map.rs: from a receiver to a texel of the map, and one comparison there.

struct MapLookup {
    clip_from_world: mat4x4f,
    light: vec4f,
    size: f32,
    texel: f32,
    constant: f32,
    slope: f32,
    slope_min: f32,
    normal_offset: f32,
    receiver_plane: f32,
}

struct Lookup {
    texel: vec2f,
    depth: f32,
    gradient: vec2f,
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

fn slide(clip_from_world: mat4x4f, clip: vec4f, tangent: vec3f, size: f32) -> vec3f {
    let m = clip_from_world;
    let c = m[0] * tangent.x + m[1] * tangent.y + m[2] * tangent.z;
    let half = size * 0.5;
    let x = clip.x / clip.w;
    let y = clip.y / clip.w;
    let z = clip.z / clip.w;
    return vec3f((c.x - x * c.w) * half, (y * c.w - c.y) * half, c.z - z * c.w);
}

fn plane_gradient(clip_from_world: mat4x4f, clip: vec4f, n: vec3f, size: f32, limit: f32) -> vec2f {
    let axis = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.x) < 0.6);
    let t = cross3(n, axis);
    let a = slide(clip_from_world, clip, t, size);
    let b = slide(clip_from_world, clip, cross3(n, t), size);
    let det = a.x * b.y - b.x * a.y;
    if det == 0.0 {
        return vec2f(0.0, 0.0);
    }
    let gx = (a.z * b.y - b.z * a.y) / det;
    let gy = (a.x * b.z - b.x * a.z) / det;
    return vec2f(max(min(gx, limit), -limit), max(min(gy, limit), -limit));
}

fn offset_along_normal(m: MapLookup, p: vec3f, n: vec3f, n_dot_l: f32) -> vec3f {
    let w = transform(m.clip_from_world, p).w;
    let metres = m.normal_offset * sine(n_dot_l) * (m.texel * w);
    return vec3f(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres);
}

fn look_up(m: MapLookup, p: vec3f, n: vec3f) -> Lookup {
    var p_offset = p;
    var bias = m.constant;
    if m.slope != 0.0 || m.slope_min != 0.0 || m.normal_offset != 0.0 {
        let n_dot_l = dot3(n, to_light(m.light, p));
        bias += slope_bias(m.slope, m.slope_min, n_dot_l);
        if m.normal_offset != 0.0 {
            p_offset = offset_along_normal(m, p, n, n_dot_l);
        }
    }
    let clip = transform(m.clip_from_world, p_offset);
    let t = texel_from_clip(clip, m.size);
    var gradient = vec2f(0.0, 0.0);
    if m.receiver_plane > 0.0 {
        gradient = plane_gradient(m.clip_from_world, clip, n, m.size, m.receiver_plane);
    }
    return Lookup(t.xy, t.z - bias, gradient, clip.w > 0.0 && t.z <= 1.0);
}

fn depth_on_plane(depth: f32, gradient: vec2f, from_texel: vec2f, x: i32, y: i32) -> f32 {
    return depth + gradient.x * (f32(x) + 0.5 - from_texel.x) + gradient.y * (f32(y) + 0.5 - from_texel.y);
}

fn depth_at(l: Lookup, x: i32, y: i32) -> f32 {
    return depth_on_plane(l.depth, l.gradient, l.texel, x, y);
}
