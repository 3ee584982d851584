// Twin of `PanesKernel` in mod.rs.

struct PanesUniforms {
    lookup: ShadowMapUniforms,
    transmittance: vec4f,
    radius: i32,
    dithered: u32,
}

// Returns whether the receiver is in front of the stored depth, like `tap` for the first image.
fn is_before(stored: f32, l: ShadowCoord, at: vec2i, is_outside_map: bool) -> bool {
    let is_lit = depth_at(l, at.x, at.y) <= stored;
    return is_lit | is_lit_outside(is_outside_map);
}

fn through(is_before: bool, at: vec2i, pane: u32) -> f32 {
    if is_before {
        return 1.0;
    }
    let transmittance = kernel.transmittance[pane];
    if kernel.dithered == 0u {
        return transmittance;
    }
    let bits = seed(u32(at.x), u32(at.y) + pane * 65536u);
    let noise = f32(bits >> 8u) / 16777216.0;
    return select(0.0, 1.0, noise < transmittance);
}

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let radius = kernel.radius;
    let x = i32(floor(l.texel.x));
    let y = i32(floor(l.texel.y));
    let size = size_0().x;
    var lit = 0.0;
    for (var dy = -radius; dy <= radius; dy++) {
        for (var dx = -radius; dx <= radius; dx++) {
            let at = vec2i(x + dx, y + dy);
            let nearest = clamp(at, vec2i(0), vec2i(size - 1));
            let is_outside_map = any(at != nearest);
            var share = tap(size, l, at.x, at.y);
            share = share * through(is_before(load_1(nearest, l.layer).x, l, at, is_outside_map), at, 0u);
            share = share * through(is_before(load_2(nearest, l.layer).x, l, at, is_outside_map), at, 1u);
            share = share * through(is_before(load_3(nearest, l.layer).x, l, at, is_outside_map), at, 2u);
            lit = lit + share;
        }
    }
    let side = f32(2 * radius + 1);
    return lit / (side * side);
}
