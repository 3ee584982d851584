// import gbuffer_visibility, holes
// The visible triangle id of each pixel, for alpha-tested triangles.

@group(0) @binding(3) var<storage> cut_outs: array<vec4u>;

@fragment
fn write_id_outside_holes(v: Vertex) -> @location(0) u32 {
    if is_hole(seen.rays, v.clip, v.triangle) {
        discard;
    }
    return v.triangle;
}
