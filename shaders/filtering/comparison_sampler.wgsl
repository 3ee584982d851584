// Twin of comparison_sampler.rs: the sampler's blend of four comparisons.

fn compared(l: ShadowCoord, size: f32, at: vec2f, depth: f32) -> f32 {
    if depth > 1.0 {
        return 0.0;
    }
    return compare_0(at / size, l.layer, depth);
}

// Samplers repeat the map's edge. WebGPU has no samplers with a border. If everything outside the
// map is lit, blend samples that touch the border explicitly, from four texels within the map.
fn sampled(l: ShadowCoord, size: f32, at: vec2f) -> f32 {
    let depth = reference_depth(l.depth, l.gradient, l.deepest, kernel.lookup.sample_gain, at - l.texel);
    if EDGE_REPEATS {
        return compared(l, size, at, depth);
    }
    if at.x < 0.5 || at.y < 0.5 || at.x > size - 0.5 || at.y > size - 0.5 {
        return sampled_at_rim(l, size, at, depth);
    }
    return compared(l, size, at, depth);
}

fn sampled_at_rim(l: ShadowCoord, size: f32, at: vec2f, depth: f32) -> f32 {
    let first = floor(at - 0.5);
    let part = at - 0.5 - first;
    let inner = max(min(first, vec2f(size - 2.0)), vec2f(0.0));
    let gathered = gather_compare_0((inner + 1.0) / size, l.layer, depth);
    let four = select(gathered, vec4f(0.0), depth > 1.0);
    let top = rim_row(size, first.x, inner.x, part.x, four.wz);
    let bottom = rim_row(size, first.x, inner.x, part.x, four.xy);
    let above = rim_answer(size, first.y, inner.y, vec2f(top, bottom));
    let below = rim_answer(size, first.y + 1.0, inner.y, vec2f(top, bottom));
    return above + (below - above) * part.y;
}

fn rim_row(size: f32, first: f32, inner: f32, part: f32, pair: vec2f) -> f32 {
    let left = rim_answer(size, first, inner, pair);
    let right = rim_answer(size, first + 1.0, inner, pair);
    return left + (right - left) * part;
}

// Returns the result of coordinate `at`. `pair` holds the results of texel `inner` and the next
// one.
fn rim_answer(size: f32, at: f32, inner: f32, pair: vec2f) -> f32 {
    if at < 0.0 || at >= size {
        return 1.0;
    }
    return select(pair.x, pair.y, at > inner);
}
