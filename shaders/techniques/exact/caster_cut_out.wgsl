// Returns whether a segment hits a caster, with alpha-tested casters. Calls `fn record_of(caster:
// u32) -> u32`, which returns the row of a caster's record, 0 if it is opaque.

fn meets_caster(o: vec3f, d: vec3f, rows: mat3x3f, caster: u32) -> bool {
    let row = 3u * caster;
    let a = corner_of(row);
    let b = corner_of(row + 1u);
    let c = corner_of(row + 2u);
    return segment_hits(o, d, rows, a, b, c) && !is_hole_met(o, d, a, b, c, record_of(caster));
}
