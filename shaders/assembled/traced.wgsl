// Made by umbrage.
struct shadow_Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
@group(0) @binding(0) var<uniform> shadow_kernel: shadow_TracedUniforms;
@group(0) @binding(1) var<storage> shadow_table_0: array<vec4u>;
@group(0) @binding(2) var<storage> shadow_table_1: array<vec4u>;
// ---- math.wgsl
// Twin of math.rs: every sum is written out, from left to right.
//
// WGSL lets drivers fuse a product with the sum that it goes into, and miss quotients and roots by
// some units in the last place. What decides whether a point is lit is written with the functions
// below. Every driver rounds them alike, unless an operand or the result is not a normal number.

// Always 0, but no compiler knows. Every entry point sets it first, from a bit of its uniforms that
// is never set: before that, product() does not prevent fusing.
var<private> shadow_opaque_zero: u32;

// a * b, rounded before it goes into a sum: no compiler fuses through the xor.
fn shadow_product(a: f32, b: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(a * b) ^ shadow_opaque_zero);
}

fn shadow_product2(a: vec2f, b: vec2f) -> vec2f {
    return bitcast<vec2f>(bitcast<vec2u>(a * b) ^ vec2u(shadow_opaque_zero));
}

fn shadow_product3(a: vec3f, b: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(a * b) ^ vec3u(shadow_opaque_zero));
}

fn shadow_product4(a: vec4f, b: vec4f) -> vec4f {
    return bitcast<vec4f>(bitcast<vec4u>(a * b) ^ vec4u(shadow_opaque_zero));
}

// The 12 leading bits of a number in 0.5..4.
fn shadow_leading_bits(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) & 0xfffff000u);
}

// a - b * c without error, for a near b * c and factors in 0.5..4: all products are of two numbers
// of 12 bits, so that fusing changes nothing (Dekker 1971, "A floating-point technique for
// extending the available precision").
fn shadow_residual(a: f32, b: f32, c: f32) -> f32 {
    let b_high = shadow_leading_bits(b);
    let c_high = shadow_leading_bits(c);
    let b_low = b - b_high;
    let c_low = c - c_high;
    return (((a - b_high * c_high) - b_high * c_low) - b_low * c_high) - b_low * c_low;
}

// Whether all numbers are finite and not below the least normal number.
fn shadow_are_normal(bits: vec3u) -> bool {
    let exponents = bits & vec3u(0x7f800000u);
    return all(exponents != vec3u(0u)) && all(exponents != vec3u(0x7f800000u));
}

// The number in 1..2 with the same fraction.
fn shadow_significand(bits: u32) -> f32 {
    return bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u);
}

fn shadow_with_sign_of(size: f32, x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(size) | (bitcast<u32>(x) & 0x80000000u));
}

// Returns a quotient of numbers in 1..2, one unit in the last place nearer to x / y unless it is
// the nearest.
fn shadow_nearer_quotient(q: f32, x: f32, y: f32, unit: f32) -> f32 {
    let rest = shadow_residual(x, q, y);
    // The nearest number leaves at most half a unit.
    return q + select(0.0, shadow_with_sign_of(unit, rest), 2.0 * abs(rest) > unit * y);
}

// a / b, rounded to nearest, by the residual of the device's own quotient (Markstein 1990,
// "Computation of elementary functions on the IBM RISC System/6000 processor"). WGSL allows an
// error of 2.5 units in the last place: at most two numbers off.
fn shadow_quotient(a: f32, b: f32) -> f32 {
    let a_bits = bitcast<u32>(a);
    let b_bits = bitcast<u32>(b);
    let rough = a / b;
    let x = shadow_significand(a_bits);
    let y = shadow_significand(b_bits);
    // The quotient is in least..2 * least, where numbers are a unit apart. The device's may be
    // less, where they are half as far apart. It is at most 2 * least, a unit from the greatest
    // quotient: that is 2 - unit at y = 1, and the next number after 2 is too far off.
    let least = select(0.5, 1.0, x >= y);
    let unit = 1.1920929e-7 * least;
    let start = max(x / y, least);
    let q = shadow_nearer_quotient(shadow_nearer_quotient(start, x, y, unit), x, y, unit);
    let exponent = (a_bits & 0x7f800000u) - (b_bits & 0x7f800000u);
    let sign = (a_bits ^ b_bits) & 0x80000000u;
    let nearest = bitcast<f32>((bitcast<u32>(q) + exponent) | sign);
    return select(rough, nearest, shadow_are_normal(vec3u(a_bits, b_bits, bitcast<u32>(rough))));
}

// Returns the root of a number in 1..4, one unit in the last place nearer unless it is the nearest.
fn shadow_nearer_root(s: f32, y: f32) -> f32 {
    let unit = 1.1920929e-7;
    let rest = shadow_residual(y, s, s);
    // Half a unit away the square differs by the product of s and the unit, and a quarter of the
    // unit's square. Residuals are multiples of that square.
    let is_low = rest > unit * s;
    let is_high = rest <= -unit * s;
    return s + select(select(0.0, -unit, is_high), unit, is_low);
}

// The square root of x, rounded to nearest. The device's own inherits its error from
// 1 / inverseSqrt(x): 2 units in the last place, and 2.5 of the quotient. After a step of Newton's
// method it is at most one number off.
fn shadow_root(x: f32) -> f32 {
    let x_bits = bitcast<u32>(x);
    // x is y times a power of 4, and y is in 1..4.
    let is_odd = (x_bits & 0x00800000u) == 0u;
    let y = shadow_significand(x_bits) * select(1.0, 2.0, is_odd);
    let rough = max(sqrt(y), 1.0);
    let start = max(rough + shadow_residual(y, rough, rough) * 0.5 / rough, 1.0);
    let s = shadow_nearer_root(start, y);
    let half_exponent = ((bitcast<i32>(x_bits) >> 23u) - select(127, 128, is_odd)) / 2;
    let nearest = bitcast<f32>(bitcast<u32>(s) + (bitcast<u32>(half_exponent) << 23u));
    let is_positive = (x_bits & 0x80000000u) == 0u;
    return select(sqrt(x), nearest, is_positive && shadow_are_normal(vec3u(x_bits)));
}

fn shadow_transform(m: mat4x4f, p: vec3f) -> vec4f {
    return shadow_product4(m[0], vec4f(p.x)) + shadow_product4(m[1], vec4f(p.y)) + shadow_product4(m[2], vec4f(p.z)) + m[3];
}

fn shadow_dot3(a: vec3f, b: vec3f) -> f32 {
    return shadow_product(a.x, b.x) + shadow_product(a.y, b.y) + shadow_product(a.z, b.z);
}

fn shadow_cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(
        shadow_product(a.y, b.z) - shadow_product(a.z, b.y),
        shadow_product(a.z, b.x) - shadow_product(a.x, b.z),
        shadow_product(a.x, b.y) - shadow_product(a.y, b.x),
    );
}

fn shadow_unit3(v: vec3f) -> vec3f {
    let length = shadow_root(shadow_dot3(v, v));
    return vec3f(shadow_quotient(v.x, length), shadow_quotient(v.y, length), shadow_quotient(v.z, length));
}

// ---- ray_box.wgsl
// Twin of slab.rs.

// 1 + 2^-19.
const shadow_EXIT_SLACK = 1.0000019;
// 2^-20 and 2^-22.
const shadow_SIZE_PAD = 9.536743e-7;
const shadow_REACH_PAD = 2.3841858e-7;

fn shadow_safe_inverse(x: f32) -> f32 {
    return select(1.0 / x, select(-1e30, 1e30, x >= 0.0), abs(x) < 1e-30);
}

fn shadow_slab_inverse(d: vec3f) -> vec3f {
    return vec3f(shadow_safe_inverse(d.x), shadow_safe_inverse(d.y), shadow_safe_inverse(d.z));
}

fn shadow_enters_box(o: vec3f, inverse: vec3f, low: vec3f, high: vec3f) -> bool {
    let a = (low - o) * inverse;
    let b = (high - o) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let entry = max(max(near.x, near.y), max(near.z, 0.0));
    let exit = min(min(far.x, far.y), min(far.z, 1.0));
    return entry <= exit * shadow_EXIT_SLACK;
}

fn shadow_box_pad(low: vec3f, high: vec3f) -> f32 {
    let size = high - low;
    let reach = max(abs(low), abs(high));
    return max(max(max(size.x, size.y), size.z) * shadow_SIZE_PAD, max(max(reach.x, reach.y), reach.z) * shadow_REACH_PAD);
}

fn shadow_padded_low(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    return low - shadow_box_pad(low, high);
}

fn shadow_padded_high(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    return high + shadow_box_pad(low, high);
}

// Whether the least rectangle around a triangle holds the origin.
fn shadow_holds_origin(a: vec2f, b: vec2f, c: vec2f) -> bool {
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    return low.x <= 0.0 && low.y <= 0.0 && high.x >= 0.0 && high.y >= 0.0;
}

// 2^-e of a number of size m 2^e, 1 <= m < 2: its exponent, mirrored.
fn shadow_inverse_power(x: f32) -> f32 {
    return bitcast<f32>(0x7f000000u - (bitcast<u32>(x) & 0x7f800000u));
}

fn shadow_enters_word(o: vec3f, inverse: vec3f, low: vec3f, high: vec3f) -> u32 {
    return u32(shadow_enters_box(o, inverse, low, high));
}

fn shadow_holds_origin_word(a: vec2f, b: vec2f, c: vec2f) -> u32 {
    return u32(shadow_holds_origin(a, b, c));
}

// ---- ray_triangle.wgsl
// Twin of ray_triangle.rs's triangle test. Calls into ray_box.wgsl.

fn shadow_shear_rows(d: vec3f) -> mat3x3f {
    let size = abs(d);
    let s = shadow_inverse_power(max(max(size.x, size.y), size.z));
    let along_z = size.z >= size.x && size.z >= size.y;
    let along_x = size.x >= size.y;
    // The greatest component last. There is one set of quotients for all three: they take long.
    let turned = select(select(d.zxy, d.yzx, along_x), d.xyz, along_z);
    let first = -shadow_quotient(turned.x, turned.z) * s;
    let second = -shadow_quotient(turned.y, turned.z) * s;
    let inverse = shadow_quotient(1.0, turned.z);
    if along_z {
        return mat3x3f(vec3f(s, 0.0, first), vec3f(0.0, s, second), vec3f(0.0, 0.0, inverse));
    }
    if along_x {
        return mat3x3f(vec3f(first, s, 0.0), vec3f(second, 0.0, s), vec3f(inverse, 0.0, 0.0));
    }
    return mat3x3f(vec3f(0.0, first, s), vec3f(s, second, 0.0), vec3f(0.0, inverse, 0.0));
}

// Columns of the matrix are rows of the shear.
fn shadow_sheared(rows: mat3x3f, v: vec3f) -> vec3f {
    return vec3f(shadow_dot3(rows[0], v), shadow_dot3(rows[1], v), shadow_dot3(rows[2], v));
}

fn shadow_cross2(a: vec3f, b: vec3f) -> f32 {
    return shadow_product(a.x, b.y) - shadow_product(a.y, b.x);
}

// `rows` are the shear's for the direction.
fn shadow_segment_hits(o: vec3f, d: vec3f, rows: mat3x3f, pa: vec3f, pb: vec3f, pc: vec3f) -> bool {
    let a = shadow_sheared(rows, pa - o);
    let b = shadow_sheared(rows, pb - o);
    let c = shadow_sheared(rows, pc - o);
    let u = shadow_cross2(b, c);
    let v = shadow_cross2(c, a);
    let w = shadow_cross2(a, b);
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if !inside {
        return false;
    }
    let whole = u + v + w;
    let along = shadow_product(u, a.z) + shadow_product(v, b.z) + shadow_product(w, c.z);
    let before = along >= 0.0 && along <= whole;
    let behind = along <= 0.0 && along >= whole;
    let between = (whole > 0.0 && before) || (whole < 0.0 && behind);
    let inverse = shadow_slab_inverse(d);
    return between && shadow_holds_origin(a.xy, b.xy, c.xy) && shadow_enters_box(o, inverse, shadow_padded_low(pa, pb, pc), shadow_padded_high(pa, pb, pc));
}

fn shadow_hit_word(o: vec3f, d: vec3f, a: vec3f, b: vec3f, c: vec3f) -> u32 {
    return u32(shadow_segment_hits(o, d, shadow_shear_rows(d), a, b, c));
}

// ---- light_sample.wgsl
// Twin of light_sample.rs: where on a light a shadow ray ends.

const shadow_LIGHT_DIRECTION = 0u;
const shadow_LIGHT_CAP = 1u;
const shadow_LIGHT_POINT = 2u;
const shadow_LIGHT_RECT = 3u;
const shadow_LIGHT_DISC = 4u;
const shadow_LIGHT_BALL = 5u;

const shadow_LIGHT_SHORT: f32 = 1.0 - 1.0 / 16384.0;
const shadow_LIGHT_LIFT: f32 = 1.0 / 1048576.0;

struct shadow_LightSampler {
    shape: vec4u,
    center: vec4f,
    half_u: vec4f,
    half_v: vec4f,
}

fn shadow_small_sin(x: f32) -> f32 {
    let q = x * x;
    let last = -1.984127e-4 + shadow_product(q, 2.755732e-6);
    return x * (1.0 + shadow_product(q, -1.6666667e-1 + shadow_product(q, 8.333333e-3 + shadow_product(q, last))));
}

fn shadow_small_cos(x: f32) -> f32 {
    let q = x * x;
    let last = -1.3888889e-3 + shadow_product(q, 2.4801587e-5);
    return 1.0 + shadow_product(q, -0.5 + shadow_product(q, 4.1666668e-2 + shadow_product(q, last)));
}

fn shadow_disc_point(uv: vec2f) -> vec2f {
    let quarter_pi = 0.7853981633974483f;
    let a = 2.0 * uv.x - 1.0;
    let b = 2.0 * uv.y - 1.0;
    if a == 0.0 && b == 0.0 {
        return vec2f(0.0, 0.0);
    }
    if abs(a) > abs(b) {
        let angle = quarter_pi * shadow_quotient(b, a);
        return vec2f(a * shadow_small_cos(angle), a * shadow_small_sin(angle));
    }
    let angle = quarter_pi * shadow_quotient(a, b);
    return vec2f(b * shadow_small_sin(angle), b * shadow_small_cos(angle));
}

fn shadow_tangent(n: vec3f) -> vec3f {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = shadow_quotient(-1.0, sign + n.z);
    return vec3f(1.0 + shadow_product(sign * n.x * n.x, a), sign * (n.x * n.y * a), -sign * n.x);
}

fn shadow_bitangent(n: vec3f) -> vec3f {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = shadow_quotient(-1.0, sign + n.z);
    return vec3f(n.x * n.y * a, sign + shadow_product(n.y * n.y, a), -n.y);
}

fn shadow_cap_direction(axis: vec3f, u: vec3f, v: vec3f, cap: f32, q: vec2f) -> vec3f {
    let h = shadow_product(shadow_product(q.x, q.x) + shadow_product(q.y, q.y), cap);
    let side = shadow_root(cap * (2.0 - h));
    return shadow_product3(axis, vec3f(1.0 - h)) + shadow_product3(u, vec3f(q.x * side)) + shadow_product3(v, vec3f(q.y * side));
}

fn shadow_segment(s: shadow_LightSampler, p: vec3f, uv: vec2f, far: f32) -> vec3f {
    let center = s.center.xyz;
    let u = s.half_u.xyz;
    let v = s.half_v.xyz;
    let kind = s.shape.x;
    if kind == shadow_LIGHT_DIRECTION {
        return center * far;
    }
    if kind == shadow_LIGHT_CAP {
        return shadow_cap_direction(center, u, v, s.half_u.w, shadow_disc_point(uv)) * far;
    }
    let to_center = center - p;
    if kind == shadow_LIGHT_POINT {
        return to_center * shadow_LIGHT_SHORT;
    }
    if kind == shadow_LIGHT_RECT {
        return (to_center + shadow_product3(u, vec3f(2.0 * uv.x - 1.0)) + shadow_product3(v, vec3f(2.0 * uv.y - 1.0))) * shadow_LIGHT_SHORT;
    }
    let q = shadow_disc_point(uv);
    if kind == shadow_LIGHT_DISC {
        return (to_center + shadow_product3(u, vec3f(q.x)) + shadow_product3(v, vec3f(q.y))) * shadow_LIGHT_SHORT;
    }
    let n = shadow_unit3(to_center);
    let r = q * s.half_u.w;
    return (to_center + shadow_product3(shadow_tangent(n), vec3f(r.x)) + shadow_product3(shadow_bitangent(n), vec3f(r.y))) * shadow_LIGHT_SHORT;
}

fn shadow_origin_offset(p: vec3f, reach: f32) -> f32 {
    return max(max(max(abs(p.x), abs(p.y)), abs(p.z)), reach) * shadow_LIGHT_LIFT;
}

fn shadow_ray_origin(p: vec3f, n: vec3f, eye: vec3f, extent: f32) -> vec3f {
    let to_eye = abs(eye - p);
    let reach = max(max(max(to_eye.x, to_eye.y), to_eye.z), extent);
    let lift = shadow_origin_offset(p, reach);
    return vec3f(p.x + shadow_product(n.x, lift), p.y + shadow_product(n.y, lift), p.z + shadow_product(n.z, lift));
}

fn shadow_hash(word: u32) -> u32 {
    var x = word;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    x ^= x >> 16u;
    return x;
}

fn shadow_seed(x: u32, y: u32) -> u32 {
    return shadow_hash(x + shadow_hash(y + 0x9e3779b9u));
}

fn shadow_owen(reversed: u32, shadow_seed: u32) -> u32 {
    var x = reversed;
    x ^= x * 0x3d20adeau;
    x += shadow_seed;
    x *= (shadow_seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

fn shadow_sobol_second(i: u32) -> u32 {
    var rest = i;
    var direction = 0x80000000u;
    var bits = 0u;
    while rest != 0u {
        if (rest & 1u) == 1u {
            bits ^= direction;
        }
        direction ^= direction >> 1u;
        rest >>= 1u;
    }
    return bits;
}

fn shadow_unit_square(i: u32, shadow_seed: u32) -> vec2f {
    let x = reverseBits(shadow_owen(i, shadow_seed));
    let y = reverseBits(shadow_owen(reverseBits(shadow_sobol_second(i)), shadow_hash(shadow_seed ^ 0x68bc21ebu)));
    return vec2f(f32(x >> 8u), f32(y >> 8u)) * (1.0 / 16777216.0);
}

// ---- leaf_opaque.wgsl
// Whether a segment meets a triangle of a leaf, where no caster has holes.

fn shadow_leaf_occludes(o: vec3f, d: vec3f, rows: mat3x3f, first: u32, count: u32, skip: u32) -> bool {
    for (var i = first; i < first + count; i++) {
        let a = shadow_table_1[3u * i];
        let b = shadow_table_1[3u * i + 1u];
        let c = shadow_table_1[3u * i + 2u];
        if a.w != skip && shadow_segment_hits(o, d, rows, bitcast<vec3f>(a.xyz), bitcast<vec3f>(b.xyz), bitcast<vec3f>(c.xyz)) {
            return true;
        }
    }
    return false;
}

// ---- traced.wgsl
// Twin of traced.rs: walks a two-way hierarchy (table_0) over triangles (table_1), any hit will do. Which hits count is said in
// leaf_opaque.wgsl or leaf_cut_out.wgsl.

struct shadow_TracedUniforms {
    light: shadow_LightSampler,
    eye: vec4f,
    extent: f32,
    far: f32,
    samples: u32,
}

const shadow_STACK = 64;

fn shadow_occluded(o: vec3f, d: vec3f, skip: u32) -> bool {
    let inverse = shadow_slab_inverse(d);
    let rows = shadow_shear_rows(d);
    var stack: array<u32, shadow_STACK>;
    var top = 1;
    stack[0] = 0u;
    while top > 0 {
        top -= 1;
        let node = stack[top];
        let low = shadow_table_0[2u * node];
        let high = shadow_table_0[2u * node + 1u];
        if !shadow_enters_box(o, inverse, bitcast<vec3f>(low.xyz), bitcast<vec3f>(high.xyz)) {
            continue;
        }
        if high.w > 0u {
            if shadow_leaf_occludes(o, d, rows, low.w, high.w, skip) {
                return true;
            }
        } else if low.w > 0u && top + 2 <= shadow_STACK {
            stack[top] = low.w;
            stack[top + 1] = low.w + 1u;
            top += 2;
        }
    }
    return false;
}

fn shadow_receive(r: shadow_Receiver) -> f32 {
    // There are less than 2^31 kinds of lights.
    shadow_opaque_zero = shadow_kernel.light.shape.x >> 31u;
    let o = shadow_ray_origin(r.position, r.normal, shadow_kernel.eye.xyz, shadow_kernel.extent);
    let scramble = shadow_seed(r.pixel.x, r.pixel.y);
    var seen = 0u;
    for (var i = 0u; i < shadow_kernel.samples; i++) {
        let d = shadow_segment(shadow_kernel.light, o, shadow_unit_square(i, scramble), shadow_kernel.far);
        if shadow_dot3(r.normal, d) > 0.0 && !shadow_occluded(o, d, r.triangle) {
            seen += 1u;
        }
    }
    return shadow_quotient(f32(seen), f32(shadow_kernel.samples));
}
