// Twin of the receiver's plane in lookup.rs: each tap's depth is that of the plane at the tap.

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

fn depth_on_plane(depth: f32, gradient: vec2f, deepest: f32, from_texel: vec2f, x: i32, y: i32) -> f32 {
    let moved = depth + gradient.x * (f32(x) + 0.5 - from_texel.x) + gradient.y * (f32(y) + 0.5 - from_texel.y);
    return min(moved, deepest);
}

fn lookup_gradient(m: ShadowMapUniforms, clip_from_world: mat4x4f, clip: vec4f, n: vec3f) -> vec2f {
    return plane_gradient(clip_from_world, clip, n, m.size, m.receiver_plane);
}

fn depth_at(l: ShadowCoord, x: i32, y: i32) -> f32 {
    return depth_on_plane(l.depth, l.gradient, l.deepest, l.texel, x, y);
}
