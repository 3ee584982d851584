// import triangle_ids, fullscreen
// The shade pass: shades the pixels that have a triangle. The mask is the last binding.

@group(UMBRAGE_GROUP) @binding(3) var umbrage_mask: texture_2d<f32>;

@fragment fn umbrage_shade(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let texel = vec2i(at.xy);
    let seen = umbrage_seen(texel);
    // A ray parallel to its triangle's plane has an id, but no normal: the pixel is empty.
    if seen.triangle == 0xffffffffu || all(seen.normal == vec3f()) {
        discard;
    }
    let visibility = textureLoad(umbrage_mask, texel, 0).x;
    return shade(Receiver(seen.position, seen.normal, vec2u(texel), seen.triangle), visibility);
}
