// Twin of pcf.rs: the mean of comparisons over a square of texels.

struct PcfUniforms {
    lookup: ShadowMapUniforms,
    radius: i32,
}

fn pcf_radius() -> i32 {
    if IS_SQUARE_OF_THREE {
        return 1;
    }
    return kernel.radius;
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let size = size_0().x;
    let x = i32(floor(l.texel.x));
    let y = i32(floor(l.texel.y));
    let radius = pcf_radius();
    var lit = 0.0;
    for (var dy = -radius; dy <= radius; dy++) {
        for (var dx = -radius; dx <= radius; dx++) {
            lit += tap(size, l, x + dx, y + dy);
        }
    }
    let side = f32(2 * radius + 1);
    return quotient(lit, side * side);
}
