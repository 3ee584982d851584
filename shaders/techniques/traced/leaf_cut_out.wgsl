// Returns whether a segment hits a triangle of a leaf, with alpha-tested casters. The fourth word
// of a triangle's second row is the row of its record in table_2, 0 if it is opaque. A segment
// continues behind a transparent texel.

fn cut_out_row(i: u32) -> vec4u {
    return table_2[i];
}

fn leaf_occludes(o: vec3f, d: vec3f, rows: mat3x3f, first: u32, count: u32, skip: u32) -> bool {
    for (var i = first; i < first + count; i++) {
        let a = table_1[3u * i];
        let b = table_1[3u * i + 1u];
        let c = table_1[3u * i + 2u];
        let pa = bitcast<vec3f>(a.xyz);
        let pb = bitcast<vec3f>(b.xyz);
        let pc = bitcast<vec3f>(c.xyz);
        if a.w != skip && segment_hits(o, d, rows, pa, pb, pc) && !is_hole_met(o, d, pa, pb, pc, b.w) {
            return true;
        }
    }
    return false;
}
