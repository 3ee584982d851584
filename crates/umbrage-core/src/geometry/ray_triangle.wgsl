// Twin of ray_triangle.rs's triangle test. Calls ray_box.wgsl.

fn shear_rows(d: vec3f) -> mat3x3f {
    let size = abs(d);
    let s = inverse_power(max(max(size.x, size.y), size.z));
    let along_z = size.z >= size.x && size.z >= size.y;
    let along_x = size.x >= size.y;
    // Move the greatest component to the end. All three cases share one set of quotients, which are
    // slow.
    let turned = select(select(d.zxy, d.yzx, along_x), d.xyz, along_z);
    let first = -quotient(turned.x, turned.z) * s;
    let second = -quotient(turned.y, turned.z) * s;
    let inverse = quotient(1.0, turned.z);
    if along_z {
        return mat3x3f(vec3f(s, 0.0, first), vec3f(0.0, s, second), vec3f(0.0, 0.0, inverse));
    }
    if along_x {
        return mat3x3f(vec3f(first, s, 0.0), vec3f(second, 0.0, s), vec3f(inverse, 0.0, 0.0));
    }
    return mat3x3f(vec3f(0.0, first, s), vec3f(s, second, 0.0), vec3f(0.0, inverse, 0.0));
}

// The columns of the matrix are the rows of the shear.
fn sheared(rows: mat3x3f, v: vec3f) -> vec3f {
    return vec3f(dot3(rows[0], v), dot3(rows[1], v), dot3(rows[2], v));
}

fn cross2(a: vec3f, b: vec3f) -> f32 {
    return product(a.x, b.y) - product(a.y, b.x);
}

// `rows` are those of the shear for the direction.
fn segment_hits(o: vec3f, d: vec3f, rows: mat3x3f, pa: vec3f, pb: vec3f, pc: vec3f) -> bool {
    let a = sheared(rows, pa - o);
    let b = sheared(rows, pb - o);
    let c = sheared(rows, pc - o);
    let u = cross2(b, c);
    let v = cross2(c, a);
    let w = cross2(a, b);
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if !inside {
        return false;
    }
    let whole = u + v + w;
    let along = product(u, a.z) + product(v, b.z) + product(w, c.z);
    let before = along >= 0.0 && along <= whole;
    let behind = along <= 0.0 && along >= whole;
    let between = (whole > 0.0 && before) || (whole < 0.0 && behind);
    let inverse = slab_inverse(d);
    let leaves = leaves_box(o, inverse, min(min(pa, pb), pc), max(max(pa, pb), pc));
    return between && holds_origin(a.xy, b.xy, c.xy) && !leaves && enters_box(o, inverse, padded_low(pa, pb, pc), padded_high(pa, pb, pc));
}

fn hit_word(o: vec3f, d: vec3f, a: vec3f, b: vec3f, c: vec3f) -> u32 {
    return u32(segment_hits(o, d, shear_rows(d), a, b, c));
}
