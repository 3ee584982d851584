// Made by umbrage.
struct shadow_Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
@group(0) @binding(0) var<uniform> shadow_kernel: shadow_SoftUniforms;
@group(0) @binding(1) var<storage> shadow_table_0: array<vec4u>;
@group(0) @binding(2) var<storage> shadow_table_1: array<vec4u>;
@group(0) @binding(3) var<storage> shadow_table_2: array<vec4u>;
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

// ---- shaft.wgsl
// Twin of shaft.rs, for shafts that start in one point.

// 2^-17.
const shadow_SHAFT_MARGIN = 7.6293945e-6;

struct shadow_Shaft {
    start: vec3f,
    low_inverse: vec3f,
    high_inverse: vec3f,
}

// All segments from `start` whose vectors end in the box from `low` to `high`.
fn shadow_shaft_to(start: vec3f, low: vec3f, high: vec3f) -> shadow_Shaft {
    let size = max(abs(low), abs(high));
    let margin = shadow_product(max(max(size.x, size.y), size.z), shadow_SHAFT_MARGIN);
    return shadow_Shaft(start, shadow_slab_inverse(low - margin), shadow_slab_inverse(high + margin));
}

fn shadow_shaft_enters(s: shadow_Shaft, low: vec3f, high: vec3f) -> bool {
    let at_high = (high - s.start) * s.low_inverse;
    let at_low = (low - s.start) * s.high_inverse;
    let low_rises = s.low_inverse >= vec3f(0.0);
    let high_rises = s.high_inverse >= vec3f(0.0);
    let until = min(select(vec3f(1.0), at_high, low_rises), select(at_low, vec3f(1.0), high_rises));
    let since = max(select(at_high, vec3f(0.0), low_rises), select(vec3f(0.0), at_low, high_rises));
    let entry = max(max(since.x, since.y), max(since.z, 0.0));
    let exit = min(min(until.x, until.y), min(until.z, 1.0));
    return entry <= exit * shadow_EXIT_SLACK;
}

fn shadow_shaft_enters_word(o: vec3f, low: vec3f, high: vec3f, box_low: vec3f, box_high: vec3f) -> u32 {
    return u32(shadow_shaft_enters(shadow_shaft_to(o, low, high), box_low, box_high));
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

// ---- soft_light_plane.wgsl
// Twin of light_plane.rs.

struct shadow_LightPlane {
    center: vec3f,
    u: vec3f,
    v: vec3f,
}

fn shadow_is_lamp() -> bool {
    let kind = shadow_kernel.light.shape.x;
    return kind != shadow_LIGHT_DIRECTION && kind != shadow_LIGHT_CAP;
}

fn shadow_light_plane(o: vec3f) -> shadow_LightPlane {
    let s = shadow_kernel.light;
    let center = s.center.xyz;
    if !shadow_is_lamp() {
        let spread = vec3f(shadow_kernel.spread.w);
        return shadow_LightPlane(center, shadow_product3(s.half_u.xyz, spread), shadow_product3(s.half_v.xyz, spread));
    }
    let to_center = center - o;
    let short = vec3f(shadow_LIGHT_SHORT);
    let middle = shadow_product3(to_center, short);
    if s.shape.x != shadow_LIGHT_BALL {
        return shadow_LightPlane(middle, shadow_product3(s.half_u.xyz, short), shadow_product3(s.half_v.xyz, short));
    }
    let n = shadow_unit3(to_center);
    let radius = vec3f(s.half_u.w * shadow_LIGHT_SHORT);
    return shadow_LightPlane(middle, shadow_product3(shadow_tangent(n), radius), shadow_product3(shadow_bitangent(n), radius));
}

// ---- soft_lattice.wgsl
// Twin of lattice.rs: reads the lattices' table (table_2).

// Most rows, and most points of a row.
const shadow_MAX_ROWS = 31;
// Neighbours across the image that share a lattice.
const shadow_NEIGHBOURS = 8u;

// A lattice: where its rows begin in table_2, and its vectors.
struct shadow_Lattice {
    at: u32,
    points: u32,
    step: vec2f,
    rise: vec2f,
    origin: vec2f,
}

fn shadow_lattice_of(pixel: vec2u) -> shadow_Lattice {
    let number = shadow_seed(pixel.x / shadow_NEIGHBOURS, pixel.y) % shadow_kernel.lattices;
    let at = number * (shadow_kernel.rows + 2u);
    let head = shadow_table_2[at];
    let rest = shadow_table_2[at + 1u];
    let vectors = bitcast<vec4f>(head);
    return shadow_Lattice(at + 2u, rest.z, vectors.xy, vectors.zw, bitcast<vec2f>(rest.xy));
}

// ---- soft_footprint.wgsl
// Twin of footprint.rs, of one receiver.

// As footprint.rs has them.
const shadow_FOOTPRINT_MARGIN = 0.01;
const shadow_DISTANCE_MARGIN = 7.6293945e-6;

// Where on the lattice boxes and triangles show.
struct shadow_Footprint {
    start: vec3f,
    along: vec3f,
    down: vec3f,
    away: vec3f,
    middle: vec2f,
    margin: vec2f,
    is_bounded: bool,
}

fn shadow_footprint_of(o: vec3f, plane: shadow_LightPlane, lattice: shadow_Lattice) -> shadow_Footprint {
    let p = shadow_product3(plane.u, vec3f(lattice.step.x)) + shadow_product3(plane.v, vec3f(lattice.step.y));
    let q = shadow_product3(plane.u, vec3f(lattice.rise.x)) + shadow_product3(plane.v, vec3f(lattice.rise.y));
    let along = shadow_cross3(q, plane.center);
    let down = shadow_cross3(plane.center, p);
    let away = shadow_cross3(p, q);
    let volume = shadow_dot3(away, plane.center);
    let sign = select(1.0, -1.0, volume < 0.0);
    let sizes = vec2f(length(along), length(down)) / abs(volume);
    let distance = length(plane.center);
    let row_shift = vec2f(shadow_kernel.shift, shadow_kernel.shift / f32(shadow_kernel.rows));
    let margin = shadow_product2(sizes, vec2f(distance * shadow_DISTANCE_MARGIN)) + shadow_FOOTPRINT_MARGIN + row_shift;
    let turn = shadow_product(lattice.step.x, lattice.rise.y) - shadow_product(lattice.rise.x, lattice.step.y);
    let place = (shadow_product(lattice.rise.x, lattice.origin.y) - shadow_product(lattice.origin.x, lattice.rise.y)) / turn;
    let row = (shadow_product(lattice.origin.x, lattice.step.y) - shadow_product(lattice.step.x, lattice.origin.y)) / turn;
    let is_bounded = max(sizes.x, sizes.y) * distance < 1e6;
    let signs = vec3f(sign);
    return shadow_Footprint(o, shadow_product3(along, signs), shadow_product3(down, signs), shadow_product3(away, signs), vec2f(place, row), margin, is_bounded);
}

// Bits of some rows of a lattice, and bits of the same places in each.
struct shadow_Part {
    rows: u32,
    places: u32,
}

// Bits from `first` to `last`, 0 to 30.
fn shadow_bits_between(first: f32, last: f32) -> u32 {
    return ((2u << u32(last)) - 1u) & ~((1u << u32(first)) - 1u);
}

// `low` and `high` bound the products with the three vectors of a footprint.
fn shadow_part_between(f: shadow_Footprint, low: vec3f, high: vec3f) -> shadow_Part {
    if !f.is_bounded || !(low.z > 0.0) {
        return shadow_Part(0xffffffffu, 0xffffffffu);
    }
    let least = min(low.xy / low.z, low.xy / high.z) + (f.middle - f.margin);
    let greatest = max(high.xy / low.z, high.xy / high.z) + (f.middle + f.margin);
    let end = vec2f(f32(shadow_MAX_ROWS - 1), f32(shadow_kernel.rows) - 1.0);
    let first = max(ceil(least), vec2f(0.0));
    let last = min(floor(greatest), end);
    if !(first.x <= last.x && first.y <= last.y) {
        return shadow_Part(0u, 0u);
    }
    return shadow_Part(shadow_bits_between(first.y, last.y), shadow_bits_between(first.x, last.x));
}

fn shadow_part_of_box(f: shadow_Footprint, low: vec3f, high: vec3f) -> shadow_Part {
    let center = (low + high) * 0.5 - f.start;
    let half = (high - low) * 0.5;
    let middle = vec3f(shadow_dot3(f.along, center), shadow_dot3(f.down, center), shadow_dot3(f.away, center));
    let reach = vec3f(shadow_dot3(abs(f.along), half), shadow_dot3(abs(f.down), half), shadow_dot3(abs(f.away), half));
    return shadow_part_between(f, middle - reach, middle + reach);
}

fn shadow_products(f: shadow_Footprint, p: vec3f) -> vec3f {
    let d = p - f.start;
    return vec3f(shadow_dot3(f.along, d), shadow_dot3(f.down, d), shadow_dot3(f.away, d));
}

// The rows in which a triangle shows; the products are those of its corners.
fn shadow_part_of_corners(f: shadow_Footprint, a: vec3f, b: vec3f, c: vec3f) -> shadow_Part {
    let least = min(a.z, min(b.z, c.z));
    if !(least > 0.0) {
        return shadow_part_between(f, vec3f(least), vec3f(least));
    }
    // As if the corners' quotients were products, with 1 as the third.
    let at_a = a.xy / a.z;
    let at_b = b.xy / b.z;
    let at_c = c.xy / c.z;
    return shadow_part_between(f, vec3f(min(at_a, min(at_b, at_c)), 1.0), vec3f(max(at_a, max(at_b, at_c)), 1.0));
}

// ---- soft_no_holes.wgsl
// What a triangle hides where no caster has holes: all of the points that its outline covers.

fn shadow_met_outside_holes(bits: u32, row: u32, o: vec3f, plane: shadow_LightPlane, first: vec2f, step: vec2f) -> u32 {
    return bits;
}

// ---- soft_hidden.wgsl
// Twin of hidden.rs, of one receiver and triangles with sorted corners (table_1).

const shadow_LEAST_GROWTH = 1e-30;

// A linear function over the light's plane: not negative where it lets points be hidden.
struct shadow_Function {
    middle: f32,
    along_u: f32,
    along_v: f32,
}

fn shadow_function_across(normal: vec3f, plane: shadow_LightPlane) -> shadow_Function {
    return shadow_Function(shadow_dot3(normal, plane.center), shadow_dot3(normal, plane.u), shadow_dot3(normal, plane.v));
}

fn shadow_function_reach(f: shadow_Function) -> f32 {
    return abs(f.along_u) + abs(f.along_v);
}

// Where along a row a function changes its sign: a root, and whether the function is not negative from there on, or up to there.
struct shadow_Cut {
    f: shadow_Function,
    inverse: f32,
    rises: bool,
}

fn shadow_cut_of(f: shadow_Function, step: vec2f) -> shadow_Cut {
    let growth = shadow_product(f.along_u, step.x) + shadow_product(f.along_v, step.y);
    let inverse = shadow_quotient(1.0, select(growth, shadow_LEAST_GROWTH, abs(growth) < shadow_LEAST_GROWTH));
    return shadow_Cut(f, inverse, inverse > 0.0);
}

fn shadow_root_of(cut: shadow_Cut, first: vec2f) -> f32 {
    let at_first = cut.f.middle + shadow_product(cut.f.along_u, first.x) + shadow_product(cut.f.along_v, first.y);
    return -at_first * cut.inverse;
}

// Lessens the places of a row, from x to y, to those where the function is not negative.
fn shadow_narrowed(run: vec2f, cut: shadow_Cut, first: vec2f) -> vec2f {
    let shadow_root = shadow_root_of(cut, first);
    return select(vec2f(run.x, min(run.y, shadow_root)), vec2f(max(run.x, shadow_root), run.y), cut.rises);
}

// The whole places from `since`, at least 0, to `until`, at most MAX_ROWS.
fn shadow_run_of_bits(since: f32, until: f32) -> u32 {
    let first = u32(min(ceil(since), f32(shadow_MAX_ROWS)));
    let after = u32(min(max(floor(until) + 1.0, 0.0), f32(shadow_MAX_ROWS)));
    return ((1u << after) - 1u) & ~((1u << first) - 1u);
}

// The light's points that nothing is known to hide, a word for each row; and the rows that have any.
//
// Loops are kept short here: Mesa's lavapipe (seen in 22.3) ends all loops of an invocation after 65,535 turns, those of eight neighbours
// counted together.
var<private> shadow_open: array<u32, shadow_MAX_ROWS>;
var<private> shadow_open_rows: u32;

// Whether any of a part may be open: two rows are looked at, others are taken for open.
fn shadow_is_part_open(part: shadow_Part) -> bool {
    var rows = part.rows & shadow_open_rows;
    if rows == 0u {
        return false;
    }
    if (shadow_open[firstTrailingBit(rows)] & part.places) != 0u {
        return true;
    }
    rows &= rows - 1u;
    if rows == 0u {
        return false;
    }
    if (shadow_open[firstTrailingBit(rows)] & part.places) != 0u {
        return true;
    }
    return (rows & (rows - 1u)) != 0u;
}

// What of the light lies above a receiver's plane is open, as far as the lattice has points there. Returns whether any is.
fn shadow_open_above_horizon(normal: vec3f, plane: shadow_LightPlane, lattice: shadow_Lattice) -> bool {
    let height = shadow_function_across(normal, plane);
    if !(height.middle + shadow_function_reach(height) > 0.0) {
        return false;
    }
    let above = shadow_cut_of(height, lattice.step);
    shadow_open_rows = 0u;
    for (var i = 0u; i < shadow_kernel.rows; i++) {
        let row = shadow_table_2[lattice.at + i];
        let run = shadow_narrowed(vec2f(0.0, f32(shadow_MAX_ROWS)), above, bitcast<vec2f>(row.xy));
        shadow_open[i] = row.z & shadow_run_of_bits(run.x, run.y);
        shadow_open_rows |= select(0u, 1u << i, shadow_open[i] != 0u);
    }
    return shadow_open_rows != 0u;
}

// Hides what a triangle hides. What it hides of what its outline covers is said in no_holes.wgsl or holes.wgsl.
fn shadow_hide(f: shadow_Footprint, plane: shadow_LightPlane, lattice: shadow_Lattice, row: u32) {
    let a_at = bitcast<vec3f>(shadow_table_1[row].xyz);
    let b_at = bitcast<vec3f>(shadow_table_1[row + 1u].xyz);
    let c_at = bitcast<vec3f>(shadow_table_1[row + 2u].xyz);
    let at_a = shadow_products(f, a_at);
    let at_b = shadow_products(f, b_at);
    let at_c = shadow_products(f, c_at);
    let part = shadow_part_of_corners(f, at_a, at_b, at_c);
    if !shadow_is_part_open(part) {
        return;
    }
    let a = a_at - f.start;
    let b = b_at - f.start;
    let a_to_b = b_at - a_at;
    let a_to_c = c_at - a_at;
    let across = shadow_cross3(a_to_b, a_to_c);
    let volume = shadow_dot3(across, a);
    if volume == 0.0 {
        return;
    }
    let sign = select(1.0, -1.0, volume < 0.0);
    let ab = shadow_function_across(shadow_cross3(a, a_to_b) * sign, plane);
    let bc = shadow_function_across(shadow_cross3(b, c_at - b_at) * sign, plane);
    let ac = shadow_function_across(shadow_cross3(a, a_to_c) * -sign, plane);
    var before = shadow_function_across(across * sign, plane);
    before.middle -= shadow_product(volume, sign);
    let reach = vec4f(shadow_function_reach(ab), shadow_function_reach(bc), shadow_function_reach(ac), shadow_function_reach(before));
    var greatest = vec4f(ab.middle, bc.middle, ac.middle, before.middle) + reach;
    if !shadow_is_lamp() {
        greatest.w = 1.0;
    }
    if any(greatest < vec4f(0.0)) {
        return;
    }
    let cut_ab = shadow_cut_of(ab, lattice.step);
    let cut_bc = shadow_cut_of(bc, lattice.step);
    let cut_ac = shadow_cut_of(ac, lattice.step);
    let cut_before = shadow_cut_of(before, lattice.step);
    for (var rows = part.rows & shadow_open_rows; rows != 0u; rows &= rows - 1u) {
        let i = firstTrailingBit(rows);
        let first = bitcast<vec2f>(shadow_table_2[lattice.at + i].xy);
        var run = vec2f(0.0, f32(shadow_MAX_ROWS));
        run = shadow_narrowed(run, cut_ab, first);
        run = shadow_narrowed(run, cut_bc, first);
        run = shadow_narrowed(run, cut_ac, first);
        if shadow_is_lamp() {
            run = shadow_narrowed(run, cut_before, first);
        }
        let covered = shadow_open[i] & shadow_run_of_bits(run.x, run.y);
        let rest = shadow_open[i] & ~shadow_met_outside_holes(covered, row, f.start, plane, first, lattice.step);
        shadow_open[i] = rest;
        shadow_open_rows &= ~select(0u, 1u << i, rest == 0u);
    }
}

// ---- soft.wgsl
// Twin of soft.rs: finds the casters in a receiver's shaft through a two-way hierarchy (table_0) over triangles with sorted corners
// (table_1), and hides points of a lattice over the light (table_2) behind them.

struct shadow_SoftUniforms {
    light: shadow_LightSampler,
    eye: vec4f,
    spread: vec4f,
    extent: f32,
    far: f32,
    shift: f32,
    rows: u32,
    lattices: u32,
}

const shadow_STACK = 64;

fn shadow_shaft_from(o: vec3f) -> shadow_Shaft {
    let center = shadow_kernel.light.center.xyz;
    let low = center - shadow_kernel.spread.xyz;
    let high = center + shadow_kernel.spread.xyz;
    if shadow_is_lamp() {
        return shadow_shaft_to(o, low - o, high - o);
    }
    let far = vec3f(shadow_kernel.far);
    return shadow_shaft_to(o, shadow_product3(low, far), shadow_product3(high, far));
}

// Hides what casters hide, triangle `skip` apart. Returns whether anything is still open.
fn shadow_search(f: shadow_Footprint, plane: shadow_LightPlane, lattice: shadow_Lattice, skip: u32) -> bool {
    let shaft = shadow_shaft_from(f.start);
    var stack: array<u32, shadow_STACK>;
    var top = 1;
    stack[0] = 0u;
    while top > 0 {
        top -= 1;
        let node = stack[top];
        let head = shadow_table_0[2u * node];
        let tail = shadow_table_0[2u * node + 1u];
        let low = bitcast<vec3f>(head.xyz);
        let high = bitcast<vec3f>(tail.xyz);
        if !shadow_shaft_enters(shaft, low, high) || !shadow_is_part_open(shadow_part_of_box(f, low, high)) {
            continue;
        }
        for (var i = head.w; i < head.w + tail.w; i++) {
            if shadow_table_1[3u * i].w != skip {
                shadow_hide(f, plane, lattice, 3u * i);
            }
        }
        if shadow_open_rows == 0u {
            return false;
        }
        if tail.w == 0u && head.w > 0u && top + 2 <= shadow_STACK {
            stack[top] = head.w;
            stack[top + 1] = head.w + 1u;
            top += 2;
        }
    }
    return true;
}

fn shadow_receive(r: shadow_Receiver) -> f32 {
    // There are less than 2^31 kinds of lights.
    shadow_opaque_zero = shadow_kernel.light.shape.x >> 31u;
    let o = shadow_ray_origin(r.position, r.normal, shadow_kernel.eye.xyz, shadow_kernel.extent);
    let plane = shadow_light_plane(o);
    let lattice = shadow_lattice_of(r.pixel);
    if !shadow_open_above_horizon(r.normal, plane, lattice) {
        return 0.0;
    }
    if !shadow_search(shadow_footprint_of(o, plane, lattice), plane, lattice, r.triangle) {
        return 0.0;
    }
    var count = 0u;
    for (var i = 0u; i < shadow_kernel.rows; i++) {
        count += countOneBits(shadow_open[i]);
    }
    return shadow_quotient(f32(count), f32(lattice.points));
}
