// Returns the visibility of a light, 0..=1, at a position (world space) with a unit normal. `pixel`
// varies the patterns of kernels that differ from pixel to pixel. Lights without shadows are lit.
fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    return shadow_on(light, position, normal, pixel, 0xffffffffu);
}

// Like `shadow`, on a triangle with a known id, which rays ignore.
fn shadow_on(light: u32, position: vec3f, normal: vec3f, pixel: vec2u, triangle: u32) -> f32 {
    if light >= SHADOW_LIGHTS {
        return 1.0;
    }
    shadow_index = light;
    let kind = shadow_set.lights[light].places.x & 0xffu;
    return shadow_of_kind(kind, Receiver(position, normal, pixel, triangle));
}
