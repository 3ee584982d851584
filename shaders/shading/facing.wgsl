// Twin of facing.rs: direction to the light.

fn turned_away(light: vec4f, p: vec3f, n: vec3f) -> u32 {
    let to_light = light.xyz - product3(p, vec3f(light.w));
    return select(0u, 1u, dot3(n, to_light) <= 0.0);
}
