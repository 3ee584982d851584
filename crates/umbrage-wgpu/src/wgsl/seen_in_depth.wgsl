// import seen, depth
// Reads `umbrage_seen` from a depth buffer.

fn umbrage_seen(texel: vec2i) -> UmbrageSeen {
    let surface = surface_at(texel);
    return UmbrageSeen(surface.position.w != 0.0, surface.position.xyz, surface.normal.xyz, 0xffffffffu);
}
