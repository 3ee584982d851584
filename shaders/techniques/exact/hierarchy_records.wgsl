// Records of alpha-tested casters, for a hierarchy: the table of cut_out.rs (table_2). The fourth
// word of a caster's second row of corners is the row of its record, 0 if it is opaque.

fn cut_out_row(i: u32) -> vec4u {
    return table_2[i];
}

fn record_of(caster: u32) -> u32 {
    return table_1[3u * caster + 1u].w;
}
