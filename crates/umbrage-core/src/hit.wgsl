// Twin of bvh.rs's triangle test.

fn segment_hits(o: vec3f, d: vec3f, pa: vec3f, pb: vec3f, pc: vec3f) -> bool {
    let a = pa - o;
    let b = pb - o;
    let c = pc - o;
    let u = dot3(d, cross3(c, b));
    let v = dot3(d, cross3(a, c));
    let w = dot3(d, cross3(b, a));
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if !inside {
        return false;
    }
    let n = cross3(b - a, c - a);
    let den = dot3(n, d);
    let num = dot3(n, a);
    if den > 0.0 {
        return num >= 0.0 && num <= den;
    }
    return den < 0.0 && num <= 0.0 && num >= den;
}

fn hit_word(o: vec3f, d: vec3f, a: vec3f, b: vec3f, c: vec3f) -> u32 {
    return u32(segment_hits(o, d, a, b, c));
}
