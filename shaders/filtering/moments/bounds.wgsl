// Twin of bounds.rs: upper bounds of light from the moments of a neighbourhood's depths.

fn chebyshev(distance: f32, variance: f32) -> f32 {
    return variance / (variance + distance * distance);
}

fn without_bleeding(lit: f32, amount: f32, scale: f32) -> f32 {
    return min(max((lit - amount) * scale, 0.0), 1.0);
}

fn lit_by_variance(moments: vec2f, depth: f32, least_variance: f32) -> f32 {
    let distance = depth - moments.x;
    let variance = max(moments.y - moments.x * moments.x, least_variance);
    return select(1.0, chebyshev(distance, variance), distance > 0.0);
}

fn lit_by_rising(moments: vec2f, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / receiver;
    let mean = moments.x * scale;
    let variance = max(moments.y * scale * scale - mean * mean, least_variance);
    return select(1.0, chebyshev(1.0 - mean, variance), moments.x < receiver);
}

fn lit_by_falling(moments: vec2f, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / moments.x;
    let depth = receiver * scale;
    let variance = max(moments.y * scale * scale - 1.0, least_variance);
    return select(1.0, chebyshev(1.0 - depth, variance), receiver < moments.x);
}
