// Follows the set's text, which defines `shadow`.
@fragment fn shade(seen: Surface) -> @location(0) vec4f {
    let normal = normalize(seen.normal);
    let pixel = vec2u(seen.at.xy);
    var light = 0.05;
    for (var i = 0u; i < LAMPS; i++) {
        let visibility = shadow(i, seen.position, normal, pixel);
        light += arriving(i, seen.position, normal) * visibility;
    }
    return vec4f(vec3f(0.5 * light), 1.0);
}
