// A light's mask, written for this image alone. Follows the texts of the receivers and of `shadow`.

@fragment fn store_mask(seen: FullscreenPixel) -> @location(0) f32 {
    let texel = vec2i(seen.at.xy);
    let depth = textureLoad(depth_of_pixel, texel, 0).x;
    if depth == 1.0 {
        return 1.0;
    }
    return shadow(seen.light, position_at(seen.at.xy, depth), vec3f(), vec2u(texel));
}
