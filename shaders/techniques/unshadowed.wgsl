// Twin of unshadowed.rs: nothing casts.

struct UnshadowedUniforms {
    light: vec4f,
}

fn receive(r: Receiver) -> f32 {
    return select(0.0, 1.0, turned_away(kernel.light, r.position, r.normal) == 0u);
}
