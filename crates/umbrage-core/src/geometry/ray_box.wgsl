// Twin of ray_box.rs.

// 1 + 2^-19.
const EXIT_SLACK = 1.0000019;
// 2^-20 and 2^-22.
const SIZE_PAD = 9.536743e-7;
const REACH_PAD = 2.3841858e-7;

fn safe_inverse(x: f32) -> f32 {
    return select(1.0 / x, select(-1e30, 1e30, x >= 0.0), abs(x) < 1e-30);
}

fn slab_inverse(d: vec3f) -> vec3f {
    return vec3f(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z));
}

fn enters_box(o: vec3f, inverse: vec3f, low: vec3f, high: vec3f) -> bool {
    let a = (low - o) * inverse;
    let b = (high - o) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let entry = max(max(near.x, near.y), max(near.z, 0.0));
    let exit = min(min(far.x, far.y), min(far.z, 1.0));
    return entry <= exit * EXIT_SLACK;
}

fn leaves_box(o: vec3f, inverse: vec3f, low: vec3f, high: vec3f) -> bool {
    let above = (o > high) & (inverse > vec3f(0.0));
    let below = (o < low) & (inverse < vec3f(0.0));
    return any(above | below);
}

fn box_pad(low: vec3f, high: vec3f) -> f32 {
    let size = high - low;
    let reach = max(abs(low), abs(high));
    return max(max(max(size.x, size.y), size.z) * SIZE_PAD, max(max(reach.x, reach.y), reach.z) * REACH_PAD);
}

fn padded_low(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    return low - box_pad(low, high);
}

fn padded_high(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    return high + box_pad(low, high);
}

// Returns whether the bounding rectangle of a triangle contains the origin.
fn holds_origin(a: vec2f, b: vec2f, c: vec2f) -> bool {
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    return low.x <= 0.0 && low.y <= 0.0 && high.x >= 0.0 && high.y >= 0.0;
}

// Returns 2^-e for a number of size m 2^e, 1 <= m < 2: its exponent, negated.
fn inverse_power(x: f32) -> f32 {
    return bitcast<f32>(0x7f000000u - (bitcast<u32>(x) & 0x7f800000u));
}

fn enters_word(o: vec3f, inverse: vec3f, low: vec3f, high: vec3f) -> u32 {
    return u32(enters_box(o, inverse, low, high));
}

fn leaves_word(o: vec3f, inverse: vec3f, low: vec3f, high: vec3f) -> u32 {
    return u32(leaves_box(o, inverse, low, high));
}

fn holds_origin_word(a: vec2f, b: vec2f, c: vec2f) -> u32 {
    return u32(holds_origin(a, b, c));
}
