// Forward: each surface asks the set's `shadow` for the lights that reach it.

fn visibility(lamp: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    return shadow(lamp, position, normal, pixel);
}

@fragment fn shade(seen: Surface) -> @location(0) vec4f {
    let normal = normalize(seen.normal);
    return picture(lit_color(seen.position, normal, albedo(seen), vec2u(seen.at.xy)));
}
