// Twin of texture.rs: repeating textures, read with explicit loads.

fn neighbours(u: f32, size: u32) -> vec2u {
    let x = floor((u - floor(u)) * f32(size) - 0.5);
    let last = size - 1u;
    let first = min(u32(max(x, 0.0)), last);
    if x < 0.0 {
        return vec2u(last, first);
    }
    return vec2u(first, select(first + 1u, 0u, first == last));
}

fn fraction(u: f32, size: u32) -> f32 {
    let x = (u - floor(u)) * f32(size) - 0.5;
    return x - floor(x);
}

// The result is exact if both are equal, so that flat maps stay flat.
fn blend(a: vec4f, b: vec4f, t: f32) -> vec4f {
    return a + (b - a) * t;
}
