// Whether a pixel lies in a hole of a triangle's. Needs `cut_outs`, the table of cut_out.rs, and `corner(i)`, the i-th corner of all triangles.

fn cut_out_row(i: u32) -> vec4u {
    return cut_outs[i];
}

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
    return is_hole_met(o, d, a, b, c, record_of(triangle));
}
