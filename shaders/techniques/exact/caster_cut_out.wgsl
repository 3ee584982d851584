// Returns whether a segment hits a caster, with alpha-tested casters. The fourth word of a caster's
// second row is the row of its record in table_4, 0 if it is opaque.

fn cut_out_row(i: u32) -> vec4u {
    return table_4[i];
}

fn meets_caster(o: vec3f, d: vec3f, rows: mat3x3f, caster: u32) -> bool {
    let row = 3u * caster;
    let a = corner_of(row);
    let b = corner_of(row + 1u);
    let c = corner_of(row + 2u);
    return segment_hits(o, d, rows, a, b, c) && !is_hole_met(o, d, a, b, c, table_3[row + 1u].w);
}
