// import fullscreen_instances
// The mask of a light of a set, whose index is the instance.

@fragment fn umbrage_mask(pixel: UmbragePixel) -> @location(0) f32 {
    let texel = vec2i(pixel.at.xy);
    let seen = umbrage_seen(texel);
    if !seen.receives {
        return 1.0;
    }
    return shadow_on(pixel.instance, seen.position, seen.normal, vec2u(texel), seen.triangle);
}
