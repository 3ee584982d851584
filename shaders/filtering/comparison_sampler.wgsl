// Twin of comparison_sampler.rs: the sampler's blend of four comparisons.

fn compared(l: ShadowCoord, size: f32, at: vec2f, depth: f32) -> f32 {
    if depth > 1.0 {
        return 0.0;
    }
    return compare_0(at / size, l.layer, depth);
}
