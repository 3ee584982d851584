// import math, resolve, ray_box, ray_triangle, cut_out, hole
// Lookup of alpha-tested triangles. holes_nearest.wgsl or holes_hashed.wgsl tests whether a pixel
// is in a hole. Needs `cut_outs`, the table of cut_out.rs, and `corner(i)`, the i-th corner of all
// triangles.

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
