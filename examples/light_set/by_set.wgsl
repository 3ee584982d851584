fn lit(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    return shadow(light, position, normal, pixel);
}
