// Twin of hausdorff.rs: the bound of four moments of depths between -1 and 1.

fn near_end(central: vec4f) -> f32 {
    return min(-1.0 - central.x, 0.0);
}

fn far_end(central: vec4f) -> f32 {
    return max(1.0 - central.x, 0.0);
}

fn lit_by_four(central: vec4f, own: f32) -> f32 {
    let near = near_end(central);
    let far = far_end(central);
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let tilt = 2.0 * central.x - central.z;
    let g1 = -(central.y * central.z);
    let g2 = central.y * (square - central.y + tilt * central.z) - central.w;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = max(own - near, 1e-9);
    if free < own {
        let to_free = max(own - free, 1e-9);
        let to_far = max(far - free, 1e-9);
        let second_mean = central.y + far * own;
        let third_mean = -(tilt + far + own + free) * central.y - far * own * free;
        let cubic = (to_near + to_far) / (2.0 * to_near) * third_mean;
        return 1.0 - (second_mean + cubic) / (to_free * to_far);
    }
    let mean = own * free * far + (own + free + far + tilt) * central.y;
    return 1.0 - mean / (2.0 * to_near * max(free - near, 1e-9));
}

fn hausdorff(moments: vec4f, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = min(max(depth, -1.0), 1.0) - central.x;
    let others = other_depths(central, own);
    let share = share_at(central, own);
    var lit = lit_by_three(central, own, share, others);
    if others.x < near_end(central) || others.y > far_end(central) {
        lit = min(max(lit_by_four(central, own), lit - share), lit);
    }
    return min(max(lit, 0.0), 1.0);
}
