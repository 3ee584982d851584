// Twin of horizon.rs: the fraction of a light above a receiver's tangent plane.

struct Horizon {
    half_u: vec4f,
    half_v: vec4f,
}

fn height_over_plane(light: vec4f, p: vec3f, n: vec3f) -> f32 {
    return dot3(n, light.xyz - product3(vec3f(light.w), p));
}

fn ball_heights(radius: f32, n: vec2f, t: vec2f) -> vec2f {
    let a = sqrt(1.0 + t.x * t.x);
    let d = sqrt(1.0 + t.x * t.x + t.y * t.y);
    return vec2f(radius * (n.x * a + n.y * (t.x * t.y / a)), radius * (n.y * (d / a)));
}

fn ball_rim(radius: f32, height: f32, distance_squared: f32) -> f32 {
    return radius * sqrt(max(1.0 - height * height / distance_squared, 0.0));
}

fn square_share(h: vec3f) -> f32 {
    let a = max(abs(h.y), abs(h.z));
    let b = min(abs(h.y), abs(h.z));
    let most = select(0.0, 1.0, h.x >= 0.0);
    if abs(h.x) >= a + b {
        return most;
    }
    let height = abs(h.x) / a;
    let slant = b / a;
    var less = 0.5 - height * 0.5;
    if height > 1.0 - slant {
        let corner = 1.0 + slant - height;
        less = corner * corner / (8.0 * slant);
    }
    return abs(most - less);
}

fn disc_share(h: vec3f) -> f32 {
    let radius = sqrt(h.y * h.y + h.z * h.z);
    let most = select(0.0, 1.0, h.x >= 0.0);
    if abs(h.x) >= radius {
        return most;
    }
    let t = abs(h.x) / radius;
    let arc = sqrt(1.0 - t) * (1.5707288 + t * (-0.2121144 + t * (0.0742610 - t * 0.0187293)));
    let less = (arc - t * sqrt(1.0 - t * t)) * 0.31830987;
    return abs(most - less);
}

fn share_above(square: u32, h: vec3f) -> f32 {
    if square != 0u {
        return square_share(h);
    }
    return disc_share(h);
}

// Returns the fraction of the light above the plane with unit normal `n` through `p`.
fn light_share(h: Horizon, square: u32, light: vec4f, p: vec3f, n: vec3f) -> f32 {
    let middle = height_over_plane(light, p, n);
    if h.half_u.w > 0.0 {
        let to_light = vec3f(light.x - p.x, light.y - p.y, light.z - p.z);
        return disc_share(vec3f(middle, ball_rim(h.half_u.w, middle, dot3(to_light, to_light)), 0.0));
    }
    return share_above(square, vec3f(middle, dot3(n, h.half_u.xyz), dot3(n, h.half_v.xyz)));
}

fn turned_heights(h: vec3f, turn: vec2f) -> vec3f {
    return vec3f(h.x, h.y * turn.x + h.z * turn.y, h.z * turn.x - h.y * turn.y);
}
