// Whether a pixel lies in a hole of a triangle's. Needs `cut_outs`, the table of cut_out.rs, and `corner(i)`, the i-th corner of all triangles.

fn record_of(triangle: u32) -> u32 {
    // First and end of two runs of triangles that have a record.
    let runs = cut_outs[0];
    if triangle < runs.y {
        return 1u + 2u * (triangle - runs.x);
    }
    return 1u + 2u * (triangle - runs.z + runs.y - runs.x);
}

fn is_hole(rays: CameraRays, at: vec4f, triangle: u32) -> bool {
    let pixel = vec2u(at.xy);
    let o = at_pixel(rays.origin, rays.origin_dx, rays.origin_dy, pixel.x, pixel.y);
    let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, pixel.x, pixel.y);
    let a = corner(3u * triangle);
    let b = corner(3u * triangle + 1u);
    let c = corner(3u * triangle + 2u);
    let record = record_of(triangle);
    let uv_ab = bitcast<vec4f>(cut_outs[record]);
    let rest = cut_outs[record + 1u];
    let size = vec2u(rest.z & 0xffffu, rest.z >> 16u);
    let texel = cut_out_texel(o, d, a, b, c, uv_ab, bitcast<vec2f>(rest.xy), size);
    return is_texel_clear(cut_outs[rest.w + (texel >> 7u)], texel);
}
