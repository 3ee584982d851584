// Pixels of a workgroup of 64 invocations: a block of 8 x 8.

// Returns the pixel of an invocation. Eight neighbours in `lane` are a block of 4 x 2 pixels, 32 one
// of 8 x 4, so that similar pixels run together.
fn umbrage_pixel(group: vec3u, lane: u32) -> vec2u {
    let x = (lane & 3u) | ((lane >> 1u) & 4u);
    let y = ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u);
    return group.xy * 8u + vec2u(x, y);
}
