// Twin of bilinear_weights.rs: positions, weights and compared depths of samples of four texels.

fn reference_depth(depth: f32, gradient: vec2f, deepest: f32, share: f32, step: vec2f) -> f32 {
    let gain = share * (abs(gradient.x) + abs(gradient.y));
    let moved = depth + gradient.x * step.x + gradient.y * step.y - gain;
    return min(moved, deepest);
}

fn merged_sample(row: vec4f, s: f32) -> vec2f {
    let first = row.x + s * row.y;
    let second = row.z + s * row.w;
    let weight = first + second;
    return vec2f(weight, second / weight);
}
