// Twin of of_depth.rs: the moments of one depth.

fn centred(depth: f32) -> f32 {
    return 2.0 * min(max(depth, 0.0), 1.0) - 1.0;
}

fn variance_moments(depth: f32) -> vec2f {
    let z = centred(depth);
    return vec2f(z, z * z);
}

fn exponential_moments(depth: f32, rising: f32, falling: f32) -> vec4f {
    let z = centred(depth);
    let up = power_of_two(rising * z);
    let down = power_of_two(-(falling * z));
    return vec4f(up, up * up, down, down * down);
}

fn power_moments(depth: f32) -> vec4f {
    let z = centred(depth);
    let square = z * z;
    return vec4f(z, square, square * z, square * square);
}
