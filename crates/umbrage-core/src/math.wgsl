// Twin of math.rs: every sum is written out, from left to right.
//
// WGSL lets drivers fuse a product with the sum that uses it. Quotients and roots may be wrong by
// some units in the last place. Code that decides whether a point is lit uses the functions below.
// Every driver that keeps the order of sums rounds them alike, unless an operand or the result is
// not a normal number.

// Always 0, but compilers can't infer it. Set it first, from a bit that is never set: in a uniform,
// or in a vertex or triangle index. Until it is set, product() does not prevent fusing.
var<private> opaque_zero: u32;

// Returns a * b, rounded before a sum uses it: no compiler fuses through the xor.
fn product(a: f32, b: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(a * b) ^ opaque_zero);
}

fn product2(a: vec2f, b: vec2f) -> vec2f {
    return bitcast<vec2f>(bitcast<vec2u>(a * b) ^ vec2u(opaque_zero));
}

fn product3(a: vec3f, b: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(a * b) ^ vec3u(opaque_zero));
}

fn product4(a: vec4f, b: vec4f) -> vec4f {
    return bitcast<vec4f>(bitcast<vec4u>(a * b) ^ vec4u(opaque_zero));
}

// Returns the 12 leading bits of a number in 0.5..4.
fn leading_bits(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) & 0xfffff000u);
}

// Returns a - b * c without error, for a near b * c and factors in 0.5..4. All products are of two
// 12-bit numbers, so fusing changes nothing (Dekker 1971, "A floating-point technique for extending
// the available precision").
fn residual(a: f32, b: f32, c: f32) -> f32 {
    let b_high = leading_bits(b);
    let c_high = leading_bits(c);
    let b_low = b - b_high;
    let c_low = c - c_high;
    return (((a - b_high * c_high) - b_high * c_low) - b_low * c_high) - b_low * c_low;
}

// Returns whether all numbers are finite and at least the least normal number.
fn are_normal(bits: vec3u) -> bool {
    let exponents = bits & vec3u(0x7f800000u);
    return all(exponents != vec3u(0u)) && all(exponents != vec3u(0x7f800000u));
}

// Returns the number in 1..2 with the same fraction.
fn significand(bits: u32) -> f32 {
    return bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u);
}

fn with_sign_of(size: f32, x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(size) | (bitcast<u32>(x) & 0x80000000u));
}

// Moves a quotient of numbers in 1..2 one unit in the last place towards x / y, unless it is
// already the nearest.
fn nearer_quotient(q: f32, x: f32, y: f32, unit: f32) -> f32 {
    let rest = residual(x, q, y);
    // The residual of the nearest number is at most half a unit.
    return q + select(0.0, with_sign_of(unit, rest), 2.0 * abs(rest) > unit * y);
}

// Returns a / b, rounded to nearest, from the residual of the device's quotient (Markstein 1990,
// "Computation of elementary functions on the IBM RISC System/6000 processor"). WGSL allows an
// error of 2.5 units in the last place: at most two numbers off.
fn quotient(a: f32, b: f32) -> f32 {
    let a_bits = bitcast<u32>(a);
    let b_bits = bitcast<u32>(b);
    let rough = a / b;
    let x = significand(a_bits);
    let y = significand(b_bits);
    // The quotient is in least..2 * least, where numbers are a unit apart. The device's quotient
    // may be below that range, where numbers are half as far apart. It is at most 2 * least: the
    // greatest quotient is 2 - unit at y = 1, and the next number after 2 is too far off.
    let least = select(0.5, 1.0, x >= y);
    let unit = 1.1920929e-7 * least;
    let start = max(x / y, least);
    let q = nearer_quotient(nearer_quotient(start, x, y, unit), x, y, unit);
    let exponent = (a_bits & 0x7f800000u) - (b_bits & 0x7f800000u);
    let sign = (a_bits ^ b_bits) & 0x80000000u;
    let nearest = bitcast<f32>((bitcast<u32>(q) + exponent) | sign);
    return select(rough, nearest, are_normal(vec3u(a_bits, b_bits, bitcast<u32>(rough))));
}

// Moves a root of a number in 1..4 one unit in the last place towards the nearest.
fn nearer_root(s: f32, y: f32) -> f32 {
    let unit = 1.1920929e-7;
    let rest = residual(y, s, s);
    // Half a unit changes the square by the product of s and the unit, and a quarter of the unit's
    // square. Residuals are multiples of that square.
    let is_low = rest > unit * s;
    let is_high = rest <= -unit * s;
    return s + select(select(0.0, -unit, is_high), unit, is_low);
}

// Returns the square root of x, rounded to nearest. The device's root inherits its error from 1 /
// inverseSqrt(x): 2 units in the last place, and 2.5 of the quotient. A step of Newton's method
// leaves it at most one number off.
fn root(x: f32) -> f32 {
    let x_bits = bitcast<u32>(x);
    // x is y times a power of 4, and y is in 1..4.
    let is_odd = (x_bits & 0x00800000u) == 0u;
    let y = significand(x_bits) * select(1.0, 2.0, is_odd);
    let rough = max(sqrt(y), 1.0);
    let start = max(rough + residual(y, rough, rough) * 0.5 / rough, 1.0);
    let s = nearer_root(start, y);
    let half_exponent = ((bitcast<i32>(x_bits) >> 23u) - select(127, 128, is_odd)) / 2;
    let nearest = bitcast<f32>(bitcast<u32>(s) + (bitcast<u32>(half_exponent) << 23u));
    let is_positive = (x_bits & 0x80000000u) == 0u;
    return select(sqrt(x), nearest, is_positive && are_normal(vec3u(x_bits)));
}

fn transform(m: mat4x4f, p: vec3f) -> vec4f {
    return product4(m[0], vec4f(p.x)) + product4(m[1], vec4f(p.y)) + product4(m[2], vec4f(p.z)) + m[3];
}

fn dot3(a: vec3f, b: vec3f) -> f32 {
    return product(a.x, b.x) + product(a.y, b.y) + product(a.z, b.z);
}

fn cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(
        product(a.y, b.z) - product(a.z, b.y),
        product(a.z, b.x) - product(a.x, b.z),
        product(a.x, b.y) - product(a.y, b.x),
    );
}

fn unit3(v: vec3f) -> vec3f {
    let length = root(dot3(v, v));
    return vec3f(quotient(v.x, length), quotient(v.y, length), quotient(v.z, length));
}
