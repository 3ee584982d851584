// import pixel_block
// The visibility of a light of a set at the pixels of its mask. Pixels that don't receive are lit.

struct UmbrageMask {
    // Index of the light.
    light: u32,
    // Layer of the masks.
    layer: u32,
    // Size of the mask, pixels.
    size: vec2u,
}

@group(UMBRAGE_GROUP) @binding(UMBRAGE_MASK_BINDING) var<uniform> umbrage_mask: UmbrageMask;

fn umbrage_visibility(at: vec2u) -> f32 {
    let seen = umbrage_seen(vec2i(at));
    if !seen.receives {
        return 1.0;
    }
    return shadow_on(umbrage_mask.light, seen.position, seen.normal, at, seen.triangle);
}
