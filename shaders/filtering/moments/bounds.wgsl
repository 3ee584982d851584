// Twin of bounds.rs: how much light the moments of a neighbourhood's depths allow.

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

fn central_moments(b: vec4f) -> vec4f {
    let variance = max(b.y - b.x * b.x, 1e-9);
    let covariance = b.z - b.x * b.y;
    let slope = covariance / variance;
    let residual = max(b.w - b.y * b.y - slope * covariance, 1e-9);
    return vec4f(b.x, variance, 2.0 * b.x - slope, residual);
}

fn not_zero(x: f32) -> f32 {
    return select(x, 1e-12, abs(x) < 1e-12);
}

fn other_depths(central: vec4f, own: f32) -> vec2f {
    let square = own * own + central.z * own - central.y;
    let a = not_zero(square);
    let b = square * central.z + central.w / central.y * own;
    let c = central.w - square * central.y;
    let root = sqrt(max(b * b - 4.0 * square * c, 0.0));
    let size = max(0.5 * (abs(b) + root), 1e-20);
    let opposite = ~bitcast<u32>(b) & 0x80000000u;
    let q = bitcast<f32>(bitcast<u32>(size) | opposite);
    let first = q / a;
    let second = c / q;
    return vec2f(min(first, second), max(first, second));
}

fn lit_by_three(central: vec4f, own: f32, others: vec2f) -> f32 {
    let square = own * own + central.z * own - central.y;
    let share = 1.0 / (1.0 + own * own / central.y + square * square / central.w);
    let span = max((own - others.x) * (others.y - others.x), 1e-20);
    let nearer = (central.y + own * others.y) / span;
    let between = select(1.0, 1.0 - nearer, others.x < own);
    return select(between, share, others.y < own);
}

fn lit_by_four(central: vec4f, own: f32) -> f32 {
    let near = -1.0 - central.x;
    let far = 1.0 - central.x;
    let third = -(central.z * central.y);
    let fourth = central.w + central.y * (central.y + central.z * central.z);
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let g1 = -third - 2.0 * central.x * central.y;
    let g2 = square * central.y - fourth - 2.0 * central.x * third;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = max(own - near, 1e-9);
    if free < own {
        let to_free = max(own - free, 1e-9);
        let to_far = max(far - free, 1e-9);
        let second_difference = -1.0 / (to_free * to_far);
        let third_difference = -0.5 * (1.0 / (to_free * to_near) + 1.0 / (to_free * to_far));
        let second_mean = central.y + far * own;
        let third_mean = third - (far + own + free) * central.y - far * own * free;
        return 1.0 + second_difference * second_mean + third_difference * third_mean;
    }
    let mean = own * free * far + (own + free + far) * central.y - third;
    return 1.0 - mean / (2.0 * to_near * max(free - near, 1e-9));
}

fn hamburger(moments: vec4f, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = depth - central.x;
    let lit = lit_by_three(central, own, other_depths(central, own));
    return min(max(lit, 0.0), 1.0);
}

fn hausdorff(moments: vec4f, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = depth - central.x;
    let others = other_depths(central, own);
    if others.x < -1.0 - central.x || others.y > 1.0 - central.x {
        return min(max(lit_by_four(central, own), 0.0), 1.0);
    }
    return min(max(lit_by_three(central, own, others), 0.0), 1.0);
}
