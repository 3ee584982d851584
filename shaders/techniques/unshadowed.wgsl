// Twin of unshadowed.rs: no shadows.

struct UnshadowedUniforms {
    light: vec4f,
}

fn receive(r: Receiver) -> f32 {
    // w is 0 or 1, so its sign bit is never set.
    opaque_zero = bitcast<u32>(kernel.light.w) >> 31u;
    return select(0.0, 1.0, turned_away(kernel.light, r.position, r.normal) == 0u);
}
