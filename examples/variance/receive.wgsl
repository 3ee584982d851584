// Twin of `Chebyshev` in mod.rs.

struct ChebyshevUniforms {
    lookup: ShadowMapUniforms,
    least_variance: f32,
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let x = i32(floor(l.texel.x));
    let y = i32(floor(l.texel.y));
    let size = i32(kernel.lookup.size);
    if x < 0 || y < 0 || x >= size || y >= size {
        return 1.0;
    }
    let m = load_0(vec2i(x, y), l.layer);
    // Receivers beyond the map are compared at its far end.
    let depth = own_depth(l);
    if depth <= m.x {
        return 1.0;
    }
    let variance = max(m.y - m.x * m.x, kernel.least_variance);
    let d = depth - m.x;
    return variance / (variance + d * d);
}
