// Twin of the functions in coord.rs that read no data: bias, projection, and the receiver's plane.

fn to_light(light: vec4f, p: vec3f) -> vec3f {
    if light.w == 0.0 {
        return light.xyz;
    }
    let d = light.xyz - p;
    // Only biases depend on it, so the driver's own root and quotient suffice.
    return d / sqrt(dot3(d, d));
}

fn slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32 {
    return max(slope * (1.0 - n_dot_l), least);
}

fn sine(cosine: f32) -> f32 {
    return sqrt(max(1.0 - cosine * cosine, 0.0));
}

fn texel_from_point(point: vec3f, size: f32) -> vec3f {
    let u = (point.x * 0.5 + 0.5) * size;
    let v = (0.5 - point.y * 0.5) * size;
    return vec3f(max(min(u, 1e6), -1e6), max(min(v, 1e6), -1e6), point.z);
}

fn slide(clip_from_world: mat4x4f, point: vec3f, tangent: vec3f, size: f32) -> vec3f {
    let m = clip_from_world;
    let c = m[0] * tangent.x + m[1] * tangent.y + m[2] * tangent.z;
    let half = size * 0.5;
    return vec3f((c.x - point.x * c.w) * half, (point.y * c.w - c.y) * half, c.z - point.z * c.w);
}

fn plane_gradient(clip_from_world: mat4x4f, point: vec3f, n: vec3f, size: f32, limit: f32) -> vec2f {
    let axis = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.x) < 0.6);
    let t = cross3(n, axis);
    let a = slide(clip_from_world, point, t, size);
    let b = slide(clip_from_world, point, cross3(n, t), size);
    let det = a.x * b.y - b.x * a.y;
    let longest = max(max(abs(a.x), abs(a.y)), max(abs(b.x), abs(b.y)));
    // Rounding gives a smaller determinant for a plane that contains the light.
    if abs(det) <= (1.0 / 1048576.0) * longest * longest {
        return vec2f(0.0, 0.0);
    }
    let right = (a.z * b.y - b.z * a.y) / det;
    let down = (a.x * b.z - b.x * a.z) / det;
    return vec2f(max(min(right, limit), -limit), max(min(down, limit), -limit));
}

fn offset_along_normal(layer: MapLayer, p: vec3f, n: vec3f, n_dot_l: f32) -> vec3f {
    let texel = layer.texel * transform(layer.clip_from_world, p).w;
    let metres = layer.normal_offset * sine(n_dot_l) * texel;
    return vec3f(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres);
}
