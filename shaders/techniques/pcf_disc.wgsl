// Twin of pcf_disc.rs: the mean of comparisons at the taps of a pattern over a disc.

struct PcfDiscUniforms {
    lookup: ShadowMapUniforms,
    radius: f32,
    taps: u32,
    turns: u32,
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let turn = pattern_row(kernel.taps + (noise_index(r.pixel.x, r.pixel.y) & kernel.turns));
    let axes = turned(vec4f(kernel.radius, 0.0, 0.0, kernel.radius), turn.xy);
    return quotient(f32(lit_taps(l, size_0().x, axes, 0u, kernel.taps, turn.zw)), f32(kernel.taps));
}
