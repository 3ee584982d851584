// import seen, depth
// Reads `umbrage_seen` from a depth buffer and a texture of normals.

@group(UMBRAGE_GROUP) @binding(2) var umbrage_normals: texture_2d<f32>;

fn umbrage_from_octahedron(folded: vec2f) -> vec3f {
    let z = 1.0 - abs(folded.x) - abs(folded.y);
    let fold = max(-z, 0.0);
    return vec3f(folded - select(vec2f(-fold), vec2f(fold), folded >= vec2f(0.0)), z);
}

fn umbrage_seen(texel: vec2i) -> UmbrageSeen {
    let depth = load_depth(texel);
    let loaded = textureLoad(umbrage_normals, texel, 0).xyz;
    let stored = select(loaded, loaded * 2.0 - 1.0, NORMALS_ARE_HALVED);
    let normal = select(stored, umbrage_from_octahedron(stored.xy), NORMALS_ARE_OCTAHEDRAL);
    // A cleared texel contains no normal: it doesn't receive.
    let receives = depth != camera.empty && dot(normal, normal) > 0.0;
    return UmbrageSeen(receives, unproject(texel, depth), normalize(normal), 0xffffffffu);
}
