// Twin of comparison_sampler.rs where the map's edge repeats: as the sampler does by itself.

fn sampled(l: ShadowCoord, size: f32, at: vec2f) -> f32 {
    return compared(l, size, at, reference_depth(l.depth, l.gradient, l.deepest, kernel.lookup.sample_gain, at - l.texel));
}
