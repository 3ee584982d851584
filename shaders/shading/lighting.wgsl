// Twin of lighting.rs: reflected light of a surface.

const MAX_SHININESS_LOG2 = 12u;

fn power(x: f32, log2: u32) -> f32 {
    var y = x;
    for (var i = 0u; i < min(log2, MAX_SHININESS_LOG2); i++) {
        y = y * y;
    }
    return y;
}

fn blinn(n: vec3f, l: vec3f, v: vec3f, shininess_log2: u32) -> vec2f {
    let diffuse = max(dot3(n, l), 0.0);
    if diffuse > 0.0 {
        let h = unit_or(l + v, n);
        return vec2f(diffuse, power(max(dot3(n, h), 0.0), shininess_log2));
    }
    return vec2f(0.0, 0.0);
}

fn cone(cosine: f32, outer: f32, scale: f32) -> f32 {
    return min(max((cosine - outer) * scale, 0.0), 1.0);
}

fn attenuation(factors: vec3f, distance: f32) -> f32 {
    return 1.0 / (factors.x + factors.y * distance + factors.z * distance * distance);
}
