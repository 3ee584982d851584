// Returns whether a segment's line meets a hole of a triangle. `record` is the row of the
// triangle's record in the table of cut_out.rs, 0 if it is opaque. Calls cut_out.wgsl and
// `fn cut_out_row(i: u32) -> vec4u`, which the shader that binds the table declares.

fn is_hole_met(o: vec3f, d: vec3f, pa: vec3f, pb: vec3f, pc: vec3f, record: u32) -> bool {
    if record == 0u {
        return false;
    }
    let uv_ab = bitcast<vec4f>(cut_out_row(record));
    let rest = cut_out_row(record + 1u);
    let size = vec2u(rest.z & 0xffffu, rest.z >> 16u);
    let texel = cut_out_texel(o, d, pa, pb, pc, uv_ab, bitcast<vec2f>(rest.xy), size);
    return is_texel_clear(cut_out_row(rest.w + (texel >> 7u)), texel);
}
