struct Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
