// The same where casters have holes: the fourth word of a triangle's second row is the row of its record in table_2, 0 if it has
// none. A segment goes on behind a hole.

fn is_hole(o: vec3f, d: vec3f, pa: vec3f, pb: vec3f, pc: vec3f, record: u32) -> bool {
    if record == 0u {
        return false;
    }
    let uv_ab = bitcast<vec4f>(table_2[record]);
    let rest = table_2[record + 1u];
    let size = vec2u(rest.z & 0xffffu, rest.z >> 16u);
    let texel = cut_out_texel(o, d, pa, pb, pc, uv_ab, bitcast<vec2f>(rest.xy), size);
    return is_texel_clear(table_2[rest.w + (texel >> 7u)], texel);
}

fn leaf_occludes(o: vec3f, d: vec3f, first: u32, count: u32, skip: u32) -> bool {
    for (var i = first; i < first + count; i++) {
        let a = table_1[3u * i];
        let b = table_1[3u * i + 1u];
        let c = table_1[3u * i + 2u];
        let pa = bitcast<vec3f>(a.xyz);
        let pb = bitcast<vec3f>(b.xyz);
        let pc = bitcast<vec3f>(c.xyz);
        if a.w != skip && segment_hits(o, d, pa, pb, pc) && !is_hole(o, d, pa, pb, pc, b.w) {
            return true;
        }
    }
    return false;
}
