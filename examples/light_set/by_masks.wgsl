@group(1) @binding(0) var masks: texture_2d_array<f32>;

fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    return textureLoad(masks, vec2i(pixel), light, 0).x;
}
