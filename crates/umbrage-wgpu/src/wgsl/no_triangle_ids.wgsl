// import seen_in_gbuffer
// Triangle ids of a G-buffer without ids: NO_TRIANGLE.

fn umbrage_triangle_at(texel: vec2i) -> u32 {
    return 0xffffffffu;
}
