// Twin of interpolation.rs: vertex attributes over a triangle, and normals perturbed by a normal
// map.

fn barycentric(p: vec3f, a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let n = cross3(b - a, c - a);
    let u = dot3(n, cross3(b - p, c - p));
    let v = dot3(n, cross3(c - p, a - p));
    let w = dot3(n, cross3(a - p, b - p));
    let sum = u + v + w;
    return vec3f(u / sum, v / sum, w / sum);
}

fn weighted(weights: vec3f, a: vec4f, b: vec4f, c: vec4f) -> vec4f {
    return a * weights.x + b * weights.y + c * weights.z;
}

fn unit_or(v: vec3f, otherwise: vec3f) -> vec3f {
    let square = dot3(v, v);
    if square > 0.0 {
        let length = sqrt(square);
        return vec3f(v.x / length, v.y / length, v.z / length);
    }
    return otherwise;
}

fn bent(n: vec3f, t: vec4f, m: vec3f) -> vec3f {
    let side = cross3(n, t.xyz);
    let b = side * select(-1.0, 1.0, t.w >= 0.0);
    return t.xyz * m.x + b * m.y + n * m.z;
}

fn on_side_of(n: vec3f, v: vec3f, facing: vec3f) -> vec3f {
    if dot3(n, facing) < 0.0 {
        return -v;
    }
    return v;
}
