// Returns whether a segment hits a triangle of a leaf, if no caster is alpha-tested.

fn leaf_occludes(o: vec3f, d: vec3f, rows: mat3x3f, first: u32, count: u32, skip: u32) -> bool {
    for (var i = first; i < first + count; i++) {
        let a = table_1[3u * i];
        let b = table_1[3u * i + 1u];
        let c = table_1[3u * i + 2u];
        if a.w != skip && segment_hits(o, d, rows, bitcast<vec3f>(a.xyz), bitcast<vec3f>(b.xyz), bitcast<vec3f>(c.xyz)) {
            return true;
        }
    }
    return false;
}
