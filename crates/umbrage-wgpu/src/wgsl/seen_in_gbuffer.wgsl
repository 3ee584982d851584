// import seen
// Reads `umbrage_seen` from positions and normals.

@group(UMBRAGE_GROUP) @binding(0) var umbrage_position: texture_2d<f32>;
@group(UMBRAGE_GROUP) @binding(1) var umbrage_normal: texture_2d<f32>;

fn umbrage_seen(texel: vec2i) -> UmbrageSeen {
    let position = textureLoad(umbrage_position, texel, 0);
    let normal = textureLoad(umbrage_normal, texel, 0).xyz;
    return UmbrageSeen(position.w != 0.0, position.xyz, normal, umbrage_triangle_at(texel));
}
