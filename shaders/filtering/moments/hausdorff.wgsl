// Twin of hausdorff.rs: the bound of four moments of depths between -1 and 1.

fn lit_by_four(central: vec4f, own: f32) -> f32 {
    let near = -1.0 - central.x;
    let far = 1.0 - central.x;
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let g1 = central.y * (central.z - 2.0 * central.x);
    let g2 = central.y * (square - central.y - central.z * (central.z - 2.0 * central.x)) - central.w;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = max(own - near, 1e-9);
    if free < own {
        let to_free = max(own - free, 1e-9);
        let to_far = max(far - free, 1e-9);
        let second_difference = -1.0 / (to_free * to_far);
        let third_difference = -0.5 * (1.0 / (to_free * to_near) + 1.0 / (to_free * to_far));
        let second_mean = central.y + far * own;
        let third_mean = -(central.z + far + own + free) * central.y - far * own * free;
        return 1.0 + second_difference * second_mean + third_difference * third_mean;
    }
    let mean = own * free * far + (own + free + far + central.z) * central.y;
    return 1.0 - mean / (2.0 * to_near * max(free - near, 1e-9));
}

fn hausdorff(moments: vec4f, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = min(max(depth, -1.0), 1.0) - central.x;
    let others = other_depths(central, own);
    if others.x < -1.0 - central.x || others.y > 1.0 - central.x {
        return min(max(lit_by_four(central, own), 0.0), 1.0);
    }
    return min(max(lit_by_three(central, own, others), 0.0), 1.0);
}
