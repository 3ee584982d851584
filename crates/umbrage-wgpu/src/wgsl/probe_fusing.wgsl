// import math, fullscreen
// Computes sums of products on the device: one expression per row, different numbers in each
// column.

@fragment
fn product_and_sum(@builtin(position) at: vec4f) -> @location(0) f32 {
    let pixel = vec2u(at.xy);
    // Always 0, as no image is that wide, but compilers can't infer it.
    opaque_zero = pixel.x >> 31u;
    // A power of two: exact on every device.
    let e = f32(pixel.x + 1u) * 0x1p-15f;
    let a = 1.0 + e;
    // a * a is 1 + 2 e + e * e, and 1 + 2 e when rounded.
    let c = -(1.0 + 2.0 * e);
    if pixel.y == 0u {
        return a * a + c;
    }
    if pixel.y == 1u {
        return fma(a, a, c);
    }
    return product(a, a) + c;
}
