// import seen_in_gbuffer
// Triangle ids of a G-buffer with ids.

@group(UMBRAGE_GROUP) @binding(2) var umbrage_triangle: texture_2d<u32>;

fn umbrage_triangle_at(texel: vec2i) -> u32 {
    return textureLoad(umbrage_triangle, texel, 0).x;
}
