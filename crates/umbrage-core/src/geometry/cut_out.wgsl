// Twin of cut_out.rs: which texel of an alpha texture a segment's line meets, and whether it is a
// hole. Calls ray_box.wgsl and ray_triangle.wgsl.

fn nearest_texel(t: f32, n: u32) -> u32 {
    if abs(t) < 8388608.0 {
        let part = t - floor(t);
        return min(u32(part * f32(n)), n - 1u);
    }
    return 0u;
}

fn uv_met(o: vec3f, d: vec3f, pa: vec3f, pb: vec3f, pc: vec3f, uv_ab: vec4f, uv_c: vec2f) -> vec2f {
    let rows = shear_rows(d);
    let a = sheared(rows, pa - o);
    let b = sheared(rows, pb - o);
    let c = sheared(rows, pc - o);
    let u = cross2(b, c);
    let v = cross2(c, a);
    let w = cross2(a, b);
    let whole = u + v + w;
    let across = quotient(product(uv_ab.x, u) + product(uv_ab.z, v) + product(uv_c.x, w), whole);
    let down = quotient(product(uv_ab.y, u) + product(uv_ab.w, v) + product(uv_c.y, w), whole);
    return vec2f(across, down);
}

fn cut_out_texel(o: vec3f, d: vec3f, pa: vec3f, pb: vec3f, pc: vec3f, uv_ab: vec4f, uv_c: vec2f, size: vec2u) -> u32 {
    let uv = uv_met(o, d, pa, pb, pc, uv_ab, uv_c);
    return nearest_texel(uv.y, size.y) * size.x + nearest_texel(uv.x, size.x);
}

// `row` is the row of the table that contains the texel's bit.
fn is_texel_clear(row: vec4u, texel: u32) -> bool {
    let word = row[(texel >> 5u) & 3u];
    return ((word >> (texel & 31u)) & 1u) == 0u;
}
