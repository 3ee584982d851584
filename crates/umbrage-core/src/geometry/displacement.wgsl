// Twin of displacement.rs: bilinear, repeating heights, and vertices moved by them.

fn repeated(t: f32) -> f32 {
    let part = t - floor(t);
    // The fraction of a tiny negative number rounds to 1.
    if part >= 1.0 {
        return 0.0;
    }
    return part;
}

fn from_first_centre(t: f32, n: u32) -> f32 {
    return repeated(t) * f32(n) - 0.5;
}

fn wrapped(t: f32, n: u32) -> u32 {
    if t < 0.0 {
        return n - 1u;
    }
    return u32(t);
}

fn bilinear_first(uv: vec2f, size: vec2u) -> vec2u {
    let x = floor(from_first_centre(uv.x, size.x));
    let y = floor(from_first_centre(uv.y, size.y));
    return vec2u(wrapped(x, size.x), wrapped(y, size.y));
}

fn bilinear_second(first: vec2u, size: vec2u) -> vec2u {
    let next = vec2u(first.x + 1u, first.y + 1u);
    return vec2u(select(next.x, 0u, next.x >= size.x), select(next.y, 0u, next.y >= size.y));
}

fn bilinear_weights(uv: vec2f, size: vec2u) -> vec2f {
    let x = from_first_centre(uv.x, size.x);
    let y = from_first_centre(uv.y, size.y);
    return vec2f(x - floor(x), y - floor(y));
}

fn bilinear_blend(top_left: f32, top_right: f32, bottom_left: f32, bottom_right: f32, weights: vec2f) -> f32 {
    let top = top_left + (top_right - top_left) * weights.x;
    let bottom = bottom_left + (bottom_right - bottom_left) * weights.x;
    return top + (bottom - top) * weights.y;
}

fn displaced(position: vec3f, normal: vec3f, h: f32, lambda: f32) -> vec3f {
    let metres = lambda * (2.0 * h - 1.0);
    return vec3f(
        position.x + normal.x * metres,
        position.y + normal.y * metres,
        position.z + normal.z * metres,
    );
}
