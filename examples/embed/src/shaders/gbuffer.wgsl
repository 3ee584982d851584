// Deferred, first half: what the camera sees goes into the program's own G-buffer.

struct Stored {
    @location(0) albedo: vec4f,
    // Rgb10a2Unorm: each component as half of it plus .5.
    @location(1) normal: vec4f,
}

@fragment fn store(seen: Surface) -> Stored {
    let normal = normalize(seen.normal);
    return Stored(vec4f(albedo(seen), 1.0), vec4f(0.5 * normal + 0.5, 1.0));
}
