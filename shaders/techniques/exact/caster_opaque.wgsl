// Returns whether a segment hits a caster, if none is alpha-tested. It has three rows of corners.

fn meets_caster(o: vec3f, d: vec3f, rows: mat3x3f, caster: u32) -> bool {
    return segment_hits(o, d, rows, corner_of(3u * caster), corner_of(3u * caster + 1u), corner_of(3u * caster + 2u));
}
