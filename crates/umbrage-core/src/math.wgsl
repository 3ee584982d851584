// Twin of math.rs: every sum is written out, from left to right.

fn transform(m: mat4x4f, p: vec3f) -> vec4f {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}

fn dot3(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn unit3(v: vec3f) -> vec3f {
    let length = sqrt(dot3(v, v));
    return vec3f(v.x / length, v.y / length, v.z / length);
}
