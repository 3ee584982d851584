// import math, fullscreen
// What the device makes of a product that goes into a sum: one way a row, other numbers in each
// column.

@fragment
fn product_and_sum(@builtin(position) at: vec4f) -> @location(0) f32 {
    let pixel = vec2u(at.xy);
    // No image is so wide: always 0, but no compiler knows.
    opaque_zero = pixel.x >> 31u;
    // A power of two: exact on every device.
    let e = f32(pixel.x + 1u) * 0x1p-15f;
    let a = 1.0 + e;
    // a * a is 1 + 2 e + e * e, and rounded 1 + 2 e.
    let c = -(1.0 + 2.0 * e);
    if pixel.y == 0u {
        return a * a + c;
    }
    if pixel.y == 1u {
        return fma(a, a, c);
    }
    return product(a, a) + c;
}
