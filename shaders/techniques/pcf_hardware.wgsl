// Twin of pcf_hardware.rs: the mean of a square of samples, one texel apart.

struct HardwareUniforms {
    lookup: ShadowMapUniforms,
    samples: i32,
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let side = f32(kernel.samples);
    let first = l.texel + (0.5 - 0.5 * side);
    var lit = 0.0;
    for (var x = 0; x < kernel.samples; x++) {
        var column = 0.0;
        for (var y = 0; y < kernel.samples; y++) {
            column += sampled(l, kernel.lookup.size, first + vec2f(f32(x), f32(y)));
        }
        lit += column;
    }
    return quotient(lit, side * side);
}
