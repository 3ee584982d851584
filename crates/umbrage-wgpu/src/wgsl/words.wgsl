// Storage of two channels per word.

// Returns words of two channels, each the nearest of 65536 steps from 0 to 1. WGSL's
// `pack2x16unorm` leaves the rounding of halves to drivers.
fn umbrage_words(channels: vec4f) -> vec2u {
    let steps = vec4u(floor(min(max(channels, vec4f(0.0)), vec4f(1.0)) * 65535.0 + 0.5));
    return steps.xz | (steps.yw << vec2u(16u));
}
