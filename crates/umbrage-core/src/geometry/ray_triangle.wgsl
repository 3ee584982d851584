// Twin of ray_triangle.rs's triangle test. Calls into ray_box.wgsl.

fn shear_rows(d: vec3f) -> mat3x3f {
    let size = abs(d);
    let s = inverse_power(max(max(size.x, size.y), size.z));
    if size.z >= size.x && size.z >= size.y {
        return mat3x3f(vec3f(s, 0.0, -(d.x / d.z) * s), vec3f(0.0, s, -(d.y / d.z) * s), vec3f(0.0, 0.0, 1.0 / d.z));
    }
    if size.x >= size.y {
        return mat3x3f(vec3f(-(d.y / d.x) * s, s, 0.0), vec3f(-(d.z / d.x) * s, 0.0, s), vec3f(1.0 / d.x, 0.0, 0.0));
    }
    return mat3x3f(vec3f(0.0, -(d.z / d.y) * s, s), vec3f(s, -(d.x / d.y) * s, 0.0), vec3f(0.0, 1.0 / d.y, 0.0));
}

// Columns of the matrix are rows of the shear: each coordinate is written out, from left to right.
fn sheared(rows: mat3x3f, v: vec3f) -> vec3f {
    return vec3f(
        rows[0].x * v.x + rows[0].y * v.y + rows[0].z * v.z,
        rows[1].x * v.x + rows[1].y * v.y + rows[1].z * v.z,
        rows[2].x * v.x + rows[2].y * v.y + rows[2].z * v.z,
    );
}

fn segment_hits(o: vec3f, d: vec3f, pa: vec3f, pb: vec3f, pc: vec3f) -> bool {
    let rows = shear_rows(d);
    let a = sheared(rows, pa - o);
    let b = sheared(rows, pb - o);
    let c = sheared(rows, pc - o);
    let u = b.x * c.y - b.y * c.x;
    let v = c.x * a.y - c.y * a.x;
    let w = a.x * b.y - a.y * b.x;
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if !inside {
        return false;
    }
    let whole = u + v + w;
    let along = u * a.z + v * b.z + w * c.z;
    let before = along >= 0.0 && along <= whole;
    let behind = along <= 0.0 && along >= whole;
    let between = (whole > 0.0 && before) || (whole < 0.0 && behind);
    let inverse = slab_inverse(d);
    return between && holds_origin(a.xy, b.xy, c.xy) && enters_box(o, inverse, padded_low(pa, pb, pc), padded_high(pa, pb, pc));
}

fn hit_word(o: vec3f, d: vec3f, a: vec3f, b: vec3f, c: vec3f) -> u32 {
    return u32(segment_hits(o, d, a, b, c));
}
