// Shades the picture from depth and normals. It stands behind the texts of the scene, of the receivers, and of `lit`.

@fragment fn shade_pixel(seen: FullscreenPixel) -> @location(0) vec4f {
    let texel = vec2i(seen.at.xy);
    let depth = textureLoad(depth_of_pixel, texel, 0).x;
    if depth == 1.0 {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let normal = textureLoad(normal_of_pixel, texel, 0).xyz;
    return shade_surface(position_at(seen.at.xy, depth), normal, vec2u(texel));
}
