// Twin of facing.rs: which way the light is.

fn turned_away(light: vec4f, p: vec3f, n: vec3f) -> u32 {
    let to_light = vec3f(light.x - p.x * light.w, light.y - p.y * light.w, light.z - p.z * light.w);
    return select(0u, 1u, dot3(n, to_light) <= 0.0);
}
