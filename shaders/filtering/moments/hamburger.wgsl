// Twin of hamburger.rs: the bound of four moments, for unbounded depths.

fn central_moments(moments: vec4f) -> vec4f {
    let b = min(max(moments, vec4f(-1.0)), vec4f(1.0));
    let variance = max(b.y - b.x * b.x, 1e-9);
    let covariance = b.z - b.x * b.y;
    let slope = covariance / variance;
    let residual = max(b.w - b.y * b.y - slope * covariance, 1e-9);
    return vec4f(b.x, variance, slope, residual);
}

fn not_zero(x: f32) -> f32 {
    return select(x, 1e-12, abs(x) < 1e-12);
}

fn other_depths(central: vec4f, own: f32) -> vec2f {
    let tilt = 2.0 * central.x - central.z;
    let square = own * (own + tilt) - central.y;
    let a = not_zero(square);
    let b = square * tilt + central.w / central.y * own;
    let c = central.w - square * central.y;
    let root = sqrt(max(b * b - 4.0 * square * c, 0.0));
    let size = max(0.5 * (abs(b) + root), 1e-20);
    let opposite = ~bitcast<u32>(b) & 0x80000000u;
    let q = bitcast<f32>(bitcast<u32>(size) | opposite);
    let first = q / a;
    let second = c / q;
    return vec2f(min(first, second), max(first, second));
}

fn share_at(central: vec4f, own: f32) -> f32 {
    let tilt = 2.0 * central.x - central.z;
    let square = own * (own + tilt) - central.y;
    return 1.0 / (1.0 + own * own / central.y + square * square / central.w);
}

fn lit_by_three(central: vec4f, own: f32, share: f32, others: vec2f) -> f32 {
    let span = max((own - others.x) * (others.y - others.x), 1e-20);
    let nearer = (central.y + own * others.y) / span;
    let between = select(1.0, 1.0 - nearer, others.x < own);
    return select(between, share, others.y < own);
}

fn hamburger(moments: vec4f, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = min(max(depth, -1.0), 1.0) - central.x;
    let share = share_at(central, own);
    let lit = lit_by_three(central, own, share, other_depths(central, own));
    return min(max(lit, 0.0), 1.0);
}
