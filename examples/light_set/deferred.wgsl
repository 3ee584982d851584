// Shades the image from depth and normals. Follows the texts of the scene, of the receivers, and of
// `shadow`.

@fragment fn shade(seen: FullscreenPixel) -> @location(0) vec4f {
    let pixel = vec2u(seen.at.xy);
    let depth = textureLoad(depth_of_pixel, pixel, 0).x;
    if depth == 1.0 {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let position = position_at(seen.at.xy, depth);
    let normal = textureLoad(normal_of_pixel, pixel, 0).xyz;
    var light = 0.05;
    for (var i = 0u; i < LAMPS; i++) {
        let visibility = shadow(i, position, normal, pixel);
        light += arriving(i, position, normal) * visibility;
    }
    return vec4f(vec3f(0.5 * light), 1.0);
}
