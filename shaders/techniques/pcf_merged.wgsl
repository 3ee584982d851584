// Twin of pcf_merged.rs: a square of samples, each of which replaces four texels of the filter.

struct MergedUniforms {
    lookup: ShadowMapUniforms,
    rows: array<vec4f, 4>,
    samples: i32,
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let centre = floor(l.texel - 0.5);
    let part = l.texel - 0.5 - centre;
    // The centre of the first texel.
    let first = centre + (1.5 - f32(kernel.samples));
    var lit = 0.0;
    var total = 0.0;
    for (var x = 0; x < kernel.samples; x++) {
        let right = merged_sample(kernel.rows[x], part.x);
        var column = 0.0;
        var column_total = 0.0;
        for (var y = 0; y < kernel.samples; y++) {
            let down = merged_sample(kernel.rows[y], part.y);
            let at = first + vec2f(f32(2 * x) + right.y, f32(2 * y) + down.y);
            column += down.x * sampled(l, kernel.lookup.size, at);
            column_total += down.x;
        }
        lit += right.x * column;
        total += right.x * column_total;
    }
    return min(lit / total, 1.0);
}
