// Twin of pcf.rs: the mean of comparisons over a square of texels.

struct PcfUniforms {
    lookup: ShadowMapUniforms,
    radius: i32,
}

// Returns the mean of the comparisons at up to `radius` texels on each side of the receiver's texel.
fn mean_of_square(l: ShadowCoord, radius: i32) -> f32 {
    let size = size_0().x;
    let x = i32(floor(l.texel.x));
    let y = i32(floor(l.texel.y));
    var lit = 0.0;
    for (var dy = -radius; dy <= radius; dy++) {
        for (var dx = -radius; dx <= radius; dx++) {
            lit += tap(size, l, x + dx, y + dy);
        }
    }
    let side = f32(2 * radius + 1);
    return quotient(lit, side * side);
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    // Compilers unroll loops whose length is a constant. As the radius is a uniform, all threads take
    // the same branch.
    if !IS_RADIUS_UNIFORM || kernel.radius == UNROLLED_RADIUS {
        return mean_of_square(l, UNROLLED_RADIUS);
    }
    return mean_of_square(l, kernel.radius);
}
