// Made by umbrage.
struct shadow_Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
@group(0) @binding(0) var<uniform> shadow_kernel: shadow_PcssUniforms;
@group(0) @binding(1) var shadow_image_0: texture_2d<f32>;
fn shadow_load_0(texel: vec2i, layer: i32) -> vec4f { return textureLoad(shadow_image_0, texel, 0); }
fn shadow_size_0() -> vec2i { return vec2i(textureDimensions(shadow_image_0)); }
@group(0) @binding(2) var shadow_image_1: texture_2d<f32>;
fn shadow_load_1(texel: vec2i, layer: i32) -> vec4f { return textureLoad(shadow_image_1, texel, 0); }
fn shadow_size_1() -> vec2i { return vec2i(textureDimensions(shadow_image_1)); }
@group(0) @binding(3) var<storage> shadow_table_0: array<vec4u>;
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

// ---- layers.wgsl
// Twin of layers.rs: a shadow map's layers, and the face of a cube in which a receiver lies. `layer_at` and `map_layer` are this
// map's choices: see choices.rs.

struct shadow_MapLayer {
    clip_from_world: mat4x4f,
    texel: f32,
    far: f32,
    constant: f32,
    slope: f32,
    slope_min: f32,
    normal_offset: f32,
    receiver_plane: f32,
    deepest_tap: f32,
    depth_in_texels: f32,
}

struct shadow_ShadowMapUniforms {
    layer_count: u32,
    packed: u32,
    clamped: u32,
    has_receiver_bias: u32,
    arrangement: u32,
    pick_reach: f32,
    blend: f32,
    layers: array<shadow_MapLayer, 8>,
    light: vec4f,
    size: f32,
    sample_gain: f32,
}

struct shadow_MapOnlyUniforms {
    lookup: shadow_ShadowMapUniforms,
}

fn shadow_cube_face(light: vec4f, p: vec3f) -> i32 {
    let d = vec3f(p.x - light.x, p.y - light.y, p.z - light.z);
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(1, 0, d.x >= 0.0);
    }
    let negative = vec2i(bitcast<vec2u>(d.yz) >> vec2u(31u, 31u));
    return select(4 + negative.y, 2 + negative.x, a.y >= a.z);
}

// ---- projection.wgsl
// Twin of the rules in coord.rs that read nothing: bias, projection, and the receiver's plane.

fn shadow_to_light(light: vec4f, p: vec3f) -> vec3f {
    if light.w == 0.0 {
        return light.xyz;
    }
    return shadow_unit3(light.xyz - p);
}

fn shadow_slope_bias(slope: f32, least: f32, n_dot_l: f32) -> f32 {
    return max(slope * (1.0 - n_dot_l), least);
}

fn shadow_sine(cosine: f32) -> f32 {
    return sqrt(max(1.0 - cosine * cosine, 0.0));
}

fn shadow_texel_from_point(point: vec3f, size: f32) -> vec3f {
    let u = (point.x * 0.5 + 0.5) * size;
    let v = (0.5 - point.y * 0.5) * size;
    return vec3f(max(min(u, 1e6), -1e6), max(min(v, 1e6), -1e6), point.z);
}

fn shadow_slide(clip_from_world: mat4x4f, point: vec3f, tangent: vec3f, size: f32) -> vec3f {
    let m = clip_from_world;
    let c = m[0] * tangent.x + m[1] * tangent.y + m[2] * tangent.z;
    let half = size * 0.5;
    return vec3f((c.x - point.x * c.w) * half, (point.y * c.w - c.y) * half, c.z - point.z * c.w);
}

fn shadow_plane_gradient(clip_from_world: mat4x4f, point: vec3f, n: vec3f, size: f32, limit: f32) -> vec2f {
    let axis = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.x) < 0.6);
    let t = shadow_cross3(n, axis);
    let a = shadow_slide(clip_from_world, point, t, size);
    let b = shadow_slide(clip_from_world, point, shadow_cross3(n, t), size);
    let first = a.x * b.y;
    let second = b.x * a.y;
    let det = first - second;
    // Less than this part of its terms is what these were rounded by: the light lies in the plane.
    if abs(det) <= (1.0 / 1048576.0) * (abs(first) + abs(second)) {
        return vec2f(0.0, 0.0);
    }
    let right = (a.z * b.y - b.z * a.y) / det;
    let down = (a.x * b.z - b.x * a.z) / det;
    return vec2f(max(min(right, limit), -limit), max(min(down, limit), -limit));
}

fn shadow_offset_along_normal(layer: shadow_MapLayer, p: vec3f, n: vec3f, n_dot_l: f32) -> vec3f {
    let texel = layer.texel * shadow_transform(layer.clip_from_world, p).w;
    let metres = layer.normal_offset * shadow_sine(n_dot_l) * texel;
    return vec3f(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres);
}

// ---- coord.wgsl
// Twin of coord.rs: from a receiver to a texel of the map. `layer_at`, `map_layer`, `biased_receiver`, `receiver_gradient`
// and `far_bound` are this map's choices: see choices.rs.

struct shadow_ShadowCoord {
    texel: vec2f,
    depth: f32,
    gradient: vec2f,
    deepest: f32,
    layer: i32,
    seen: bool,
}

// The receiver's place, and in w its bias.
fn shadow_receiver_with_slope_bias(layer: shadow_MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    let n_dot_l = shadow_dot3(n, shadow_to_light(light, p));
    return vec4f(p, layer.constant + shadow_slope_bias(layer.slope, layer.slope_min, n_dot_l));
}

// The same, moved along its normal.
fn shadow_receiver_with_normal_offset(layer: shadow_MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    let n_dot_l = shadow_dot3(n, shadow_to_light(light, p));
    let bias = layer.constant + shadow_slope_bias(layer.slope, layer.slope_min, n_dot_l);
    return vec4f(shadow_offset_along_normal(layer, p, n, n_dot_l), bias);
}

fn shadow_shadow_coord(m: shadow_ShadowMapUniforms, p: vec3f, n: vec3f) -> shadow_ShadowCoord {
    return shadow_shadow_coord_in(shadow_layer_at(m.light, p), m, p, n);
}

fn shadow_shadow_coord_in(index: i32, m: shadow_ShadowMapUniforms, p: vec3f, n: vec3f) -> shadow_ShadowCoord {
    let layer = shadow_map_layer(index);
    let biased = shadow_biased_receiver(layer, m.light, p, n);
    let clip = shadow_transform(layer.clip_from_world, biased.xyz);
    let point = vec3f(clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    // The texture tells its side for all lanes at once; drivers that run on the CPU read a word of one light among many lane by lane.
    let side = f32(shadow_size_0().x);
    let texel = shadow_texel_from_point(point, side);
    let gradient = shadow_receiver_gradient(layer, point, n, side);
    let depth = point.z - biased.w;
    let deepest = max(depth, layer.deepest_tap);
    let seen = clip.w > 0.0 && point.z <= shadow_far_bound(layer);
    return shadow_ShadowCoord(texel.xy, depth, gradient, deepest, index, seen);
}

// ---- depth_on_plane.wgsl
// Twin of `depth_on_plane` in texel_compare.rs. Apart from texel_compare.wgsl, since the twin tests use it without an image.

fn shadow_depth_on_plane(depth: f32, gradient: vec2f, deepest: f32, from_texel: vec2f, x: i32, y: i32) -> f32 {
    let right = gradient.x * (f32(x) + 0.5 - from_texel.x);
    let down = gradient.y * (f32(y) + 0.5 - from_texel.y);
    return min(depth + right + down, deepest);
}

// ---- texel_compare.wgsl
// Twin of texel_compare.rs: the comparison with one texel of the kernel's first image. `depth_at`, `stored_depth` and
// `is_lit_beside` are this map's choices (see choices.rs) among the variants below.

// Where the receiver's plane is followed.
fn shadow_depth_at_on_plane(l: shadow_ShadowCoord, x: i32, y: i32) -> f32 {
    return shadow_depth_on_plane(l.depth, l.gradient, l.deepest, l.texel, x, y);
}

// Where it is not: one depth for all taps.
fn shadow_depth_at_receiver(l: shadow_ShadowCoord, x: i32, y: i32) -> f32 {
    return l.depth;
}

fn shadow_tap(size: i32, l: shadow_ShadowCoord, x: i32, y: i32) -> f32 {
    let at = vec2i(x, y);
    // Loaded in any case, so that there is no branch for each tap.
    let nearest = clamp(at, vec2i(0), vec2i(size - 1));
    let is_lit = shadow_depth_at(l, x, y) <= shadow_stored_depth(nearest, l.layer);
    return select(0.0, 1.0, is_lit | shadow_is_lit_beside(any(at != nearest)));
}

// ---- receive.wgsl
// What every map technique's kernel does: it picks a layer, finds the receiver's place there, and asks the technique. `visibility` is
// the technique's, and `full_light` its own or the choice's. `receive` is the map's choice between the variants below.

// The answer of one layer.
fn shadow_visibility_in(layer: i32, r: shadow_Receiver) -> f32 {
    let l = shadow_shadow_coord_in(layer, shadow_kernel.lookup, r.position, r.normal);
    if !l.seen {
        return shadow_full_light(r);
    }
    return shadow_visibility(l, r);
}

// Where each receiver has one layer.
fn shadow_receive_from_one(r: shadow_Receiver) -> f32 {
    // w is 0 or 1: its sign is never set.
    shadow_opaque_zero = bitcast<u32>(shadow_kernel.lookup.light.w) >> 31u;
    return shadow_visibility_in(shadow_layer_at(shadow_kernel.lookup.light, r.position), r);
}

// ---- packing.wgsl
// Twin of packing.rs: depth in base 256.

fn shadow_pack_depth(z: f32) -> vec4f {
    let a = z * 256.0;
    let ka = min(floor(a), 255.0);
    let b = (a - ka) * 256.0;
    let kb = min(floor(b), 255.0);
    let c = (b - kb) * 256.0;
    let kc = min(floor(c), 255.0);
    let d = (c - kc) * 256.0;
    let kd = min(floor(d), 255.0);
    return vec4f(ka / 255.0, kb / 255.0, kc / 255.0, kd / 255.0);
}

fn shadow_unpack_depth(c: vec4f) -> f32 {
    let k = floor(c * 255.0 + vec4f(0.5));
    let digit_size = 1.0 / 256.0;
    return (k.x + (k.y + (k.z + k.w * digit_size) * digit_size) * digit_size) * digit_size;
}

// ---- stored_depth.wgsl
// The depth at a texel of the kernel's first image. `stored_depth` is the map's choice (see choices.rs) between these.

// Depth that is stored as it is.
fn shadow_stored_depth_plain(texel: vec2i, layer: i32) -> f32 {
    return shadow_load_0(texel, layer).x;
}

// Depth in four channels.
fn shadow_stored_depth_packed(texel: vec2i, layer: i32) -> f32 {
    return shadow_unpack_depth(shadow_load_0(texel, layer));
}

// ---- choice: plain depth
fn shadow_stored_depth(texel: vec2i, layer: i32) -> f32 { return shadow_stored_depth_plain(texel, layer); }

// ---- choice: one map
fn shadow_layer_at(light: vec4f, p: vec3f) -> i32 { return 0; }
fn shadow_map_layer(layer: i32) -> shadow_MapLayer { return shadow_kernel.lookup.layers[0]; }

// ---- choice: one layer answers
fn shadow_receive(r: shadow_Receiver) -> f32 { return shadow_receive_from_one(r); }

// ---- choice: a constant bias
fn shadow_biased_receiver(layer: shadow_MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f { return vec4f(p, layer.constant); }

// ---- choice: taps follow the receiver's plane
fn shadow_receiver_gradient(layer: shadow_MapLayer, point: vec3f, n: vec3f, size: f32) -> vec2f {
    return shadow_plane_gradient(layer.clip_from_world, point, n, size, layer.receiver_plane);
}
fn shadow_depth_at(l: shadow_ShadowCoord, x: i32, y: i32) -> f32 { return shadow_depth_at_on_plane(l, x, y); }

// ---- choice: lit border
fn shadow_is_lit_beside(is_outside: bool) -> bool { return is_outside; }

// ---- choice: lit beyond the far plane
fn shadow_far_bound(layer: shadow_MapLayer) -> f32 { return 1.0; }

// ---- light_extent.wgsl
// Twin of light_extent.rs: the light's half axes on the map, texels per unit of clip depth.

struct shadow_LightExtent {
    half_axis_u: array<vec4f, 8>,
    half_axis_v: array<vec4f, 8>,
}

fn shadow_light_axes(half_axis_u: vec4f, half_axis_v: vec4f, shadow_from_middle: vec2f) -> vec4f {
    let x = shadow_from_middle.x;
    let y = shadow_from_middle.y;
    if half_axis_u.w > 0.0 {
        let tx = x * half_axis_u.w;
        let ty = y * half_axis_u.w;
        let a = sqrt(1.0 + tx * tx);
        let d = sqrt(1.0 + tx * tx + ty * ty);
        return vec4f(half_axis_u.x * a, half_axis_u.x * (tx * ty / a), 0.0, half_axis_u.x * (d / a));
    }
    return vec4f(half_axis_u.x + half_axis_u.z * x, half_axis_u.y + half_axis_u.z * y, half_axis_v.x + half_axis_v.z * x, half_axis_v.y + half_axis_v.z * y);
}

fn shadow_reach_along(square: u32, axes: vec4f) -> vec2f {
    let a = axes * axes;
    let disc = vec2f(sqrt(a.x + a.z), sqrt(a.y + a.w));
    let b = abs(axes);
    return select(disc, vec2f(b.x + b.z, b.y + b.w), square != 0u);
}

fn shadow_texel_depth(reach: vec2f) -> f32 {
    return 1.0 / min(max(max(reach.x, reach.y), 1e-9), 1e9);
}

// ---- horizon.wgsl
// Twin of horizon.rs: how much of a light a receiver's own tangent plane leaves.

struct shadow_Horizon {
    half_u: vec4f,
    half_v: vec4f,
}

fn shadow_height_over_plane(light: vec4f, p: vec3f, n: vec3f) -> f32 {
    return shadow_dot3(n, light.xyz - shadow_product3(vec3f(light.w), p));
}

fn shadow_ball_heights(radius: f32, n: vec2f, t: vec2f) -> vec2f {
    let a = sqrt(1.0 + t.x * t.x);
    let d = sqrt(1.0 + t.x * t.x + t.y * t.y);
    return vec2f(radius * (n.x * a + n.y * (t.x * t.y / a)), radius * (n.y * (d / a)));
}

fn shadow_ball_rim(radius: f32, height: f32, distance_squared: f32) -> f32 {
    return radius * sqrt(max(1.0 - height * height / distance_squared, 0.0));
}

fn shadow_square_share(h: vec3f) -> f32 {
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

fn shadow_disc_share(h: vec3f) -> f32 {
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

fn shadow_share_above(square: u32, h: vec3f) -> f32 {
    if square != 0u {
        return shadow_square_share(h);
    }
    return shadow_disc_share(h);
}

// The share of the light above the plane with unit normal `n` through `p`.
fn shadow_light_share(h: shadow_Horizon, square: u32, light: vec4f, p: vec3f, n: vec3f) -> f32 {
    let middle = shadow_height_over_plane(light, p, n);
    if h.half_u.w > 0.0 {
        let shadow_to_light = vec3f(light.x - p.x, light.y - p.y, light.z - p.z);
        return shadow_disc_share(vec3f(middle, shadow_ball_rim(h.half_u.w, middle, shadow_dot3(shadow_to_light, shadow_to_light)), 0.0));
    }
    return shadow_share_above(square, vec3f(middle, shadow_dot3(n, h.half_u.xyz), shadow_dot3(n, h.half_v.xyz)));
}

fn shadow_turned_heights(h: vec3f, turn: vec2f) -> vec3f {
    return vec3f(h.x, h.y * turn.x + h.z * turn.y, h.z * turn.x - h.y * turn.y);
}

// ---- sample_pattern.wgsl
// Twin of sample_pattern.rs: a pixel's turn or shift of the pattern, where its taps lie on the map, and what they weigh.

fn shadow_noise_index(x: u32, y: u32) -> u32 {
    let a = x * 288237660u + y * 25070368u;
    return (a * 52u + (a >> 16u) * 64417u) >> 26u;
}

fn shadow_turned(axes: vec4f, turn: vec2f) -> vec4f {
    return vec4f(
        axes.x * turn.x + axes.z * turn.y,
        axes.y * turn.x + axes.w * turn.y,
        axes.z * turn.x - axes.x * turn.y,
        axes.w * turn.x - axes.y * turn.y,
    );
}

fn shadow_wrapped(x: f32) -> f32 {
    return select(x, x - 2.0, x >= 1.0);
}

fn shadow_place(at: vec2f, axes: vec4f, q: vec2f) -> vec2f {
    return vec2f(at.x + axes.x * q.x + axes.z * q.y, at.y + axes.y * q.x + axes.w * q.y);
}

fn shadow_tap_place(at: vec2f, axes: vec4f, q: vec2f, shift: vec2f) -> vec2f {
    return shadow_place(at, axes, vec2f(shadow_wrapped(q.x + shift.x), shadow_wrapped(q.y + shift.y)));
}

fn shadow_from_middle(x: f32, y: f32, least: f32) -> f32 {
    return max(max(abs(x), abs(y)), least);
}

fn shadow_closer_by(m: f32) -> f32 {
    return m * m;
}

fn shadow_tap_weight(m: f32, nearer: f32) -> f32 {
    return m * m * (m * m) / (nearer * nearer);
}

// ---- pattern_taps.wgsl
// Twin of pattern_taps.rs: the kernel's first table holds the taps of its sets, then the turns.

fn shadow_pattern_row(i: u32) -> vec4f {
    return bitcast<vec4f>(shadow_table_0[i]);
}

// The depth stored at a place, and the receiver's there. Outside the map nothing is nearer, unless its edge repeats.
fn shadow_place_depths(l: shadow_ShadowCoord, size: i32, at: vec2f) -> vec2f {
    let x = i32(floor(at.x));
    let y = i32(floor(at.y));
    let receiver = shadow_depth_at(l, x, y);
    let texel = vec2i(clamp(x, 0, size - 1), clamp(y, 0, size - 1));
    if shadow_kernel.lookup.clamped == 0u && (texel.x != x || texel.y != y) {
        return vec2f(2.0, receiver);
    }
    return vec2f(shadow_stored_depth(texel, l.layer), receiver);
}

fn shadow_lit_taps(l: shadow_ShadowCoord, size: i32, axes: vec4f, first: u32, count: u32, shift: vec2f) -> i32 {
    var lit = 0;
    for (var shadow_tap = first; shadow_tap < first + count; shadow_tap++) {
        let d = shadow_place_depths(l, size, shadow_tap_place(l.texel, axes, shadow_pattern_row(shadow_tap).xy, shift));
        lit += select(0, 1, d.y <= d.x);
    }
    return lit;
}

// ---- pcss.wgsl
// Twin of pcss.rs: bounds the search, searches for blockers, estimates the penumbra's width, and filters that widely.

struct shadow_PcssUniforms {
    lookup: shadow_ShadowMapUniforms,
    extent: shadow_LightExtent,
    horizon: shadow_Horizon,
    blocker_taps: u32,
    filter_taps: u32,
    turns: u32,
    square: u32,
    cell: u32,
}

// A receiver's place on the map, the light's half axes there (turned), the bounds of differences of clip depth (`most` is the
// greatest that is followed, `texel` the one that moves the light's rim by a texel), and the heights of the light's points.
struct shadow_Soft {
    l: shadow_ShadowCoord,
    size: i32,
    axes: vec4f,
    most: f32,
    texel: f32,
    shift: vec2f,
    heights: vec3f,
}

// A shifted tap: its place in the pattern, and how far that is from the middle.
fn shadow_spot(s: shadow_Soft, shadow_tap: u32) -> vec3f {
    let row = shadow_pattern_row(shadow_tap);
    let x = shadow_wrapped(row.x + s.shift.x);
    let y = shadow_wrapped(row.y + s.shift.y);
    return vec3f(x, y, shadow_from_middle(x, y, row.z));
}

// By how much blockers are nearer in the mean; the whole search if it finds none.
fn shadow_mean_nearer(s: shadow_Soft, widest: f32) -> f32 {
    let axes = s.axes * widest;
    var sum = 0.0;
    var weights = 0.0;
    for (var shadow_tap = 0u; shadow_tap < shadow_kernel.blocker_taps; shadow_tap++) {
        let q = shadow_spot(s, shadow_tap);
        let closer = shadow_closer_by(q.z);
        let d = shadow_place_depths(s.l, s.size, shadow_place(s.l.texel, axes, q.xy * closer));
        let nearer = s.l.depth - d.x;
        if !(d.y <= d.x) && nearer >= widest * (q.z * closer) {
            let weight = shadow_tap_weight(q.z, max(nearer, s.texel));
            sum += weight * (d.y - d.x);
            weights += weight;
        }
    }
    if weights > 0.0 {
        return sum / weights;
    }
    return widest;
}

// Whether something hides the light's point at the tap: what is found there, or, if that is too low to be in the way, what the
// ray passes where it is as low.
fn shadow_hides(s: shadow_Soft, q: vec3f, axes: vec4f, mean: f32) -> bool {
    let d = shadow_place_depths(s.l, s.size, shadow_place(s.l.texel, axes, q.xy));
    if d.y <= d.x {
        return false;
    }
    let nearer = s.l.depth - d.x;
    if nearer >= mean * q.z {
        return true;
    }
    if nearer <= 0.0 {
        return false;
    }
    let lower = shadow_place_depths(s.l, s.size, shadow_place(s.l.texel, s.axes * nearer, q.xy));
    return !(lower.y <= lower.x) && s.l.depth - lower.x >= nearer * 0.5;
}

// The share of the light above the horizon that is seen: 1 where no tap is above it.
fn shadow_filtered(s: shadow_Soft, mean: f32) -> f32 {
    let axes = s.axes * min(max(mean, s.texel), s.most);
    var above = 0;
    var lit = 0;
    for (var shadow_tap = shadow_kernel.blocker_taps; shadow_tap < shadow_kernel.blocker_taps + shadow_kernel.filter_taps; shadow_tap++) {
        let q = shadow_spot(s, shadow_tap);
        if s.heights.x + s.heights.y * q.x + s.heights.z * q.y > 0.0 {
            above += 1;
            lit += select(1, 0, shadow_hides(s, q, axes, mean));
        }
    }
    return select(1.0, shadow_quotient(f32(lit), f32(above)), above > 0);
}

fn shadow_heights_of_light(r: shadow_Receiver, layer: i32, shadow_from_middle: vec2f) -> vec3f {
    let middle = shadow_height_over_plane(shadow_kernel.lookup.light, r.position, r.normal);
    let h = shadow_kernel.horizon;
    if h.half_u.w > 0.0 {
        let face = shadow_map_layer(layer).clip_from_world;
        let tangent = shadow_kernel.extent.half_axis_u[layer].w;
        let unit = tangent * (shadow_kernel.lookup.size * 0.5);
        let right = face[0].x * r.normal.x + face[1].x * r.normal.y + face[2].x * r.normal.z;
        let up = face[0].y * r.normal.x + face[1].y * r.normal.y + face[2].y * r.normal.z;
        let grows = shadow_ball_heights(h.half_u.w, vec2f(right * unit, -up * unit), shadow_from_middle * tangent);
        return vec3f(middle, grows);
    }
    return vec3f(middle, shadow_dot3(r.normal, h.half_u.xyz), shadow_dot3(r.normal, h.half_v.xyz));
}

// The least clip depth at which something may hide some of the light.
fn shadow_depth_in_reach(l: shadow_ShadowCoord) -> f32 {
    let last = i32(shadow_kernel.lookup.size) - 1;
    let x = clamp(i32(floor(l.texel.x)), 0, last) / i32(shadow_kernel.cell);
    let y = clamp(i32(floor(l.texel.y)), 0, last) / i32(shadow_kernel.cell);
    return shadow_load_1(vec2i(x, y), l.layer).x;
}

// The share of the light above the horizon.
fn shadow_full_light(r: shadow_Receiver) -> f32 {
    return shadow_light_share(shadow_kernel.horizon, shadow_kernel.square, shadow_kernel.lookup.light, r.position, r.normal);
}

fn shadow_visibility(l: shadow_ShadowCoord, r: shadow_Receiver) -> f32 {
    let share = shadow_full_light(r);
    let half_axis_v = shadow_kernel.extent.half_axis_v[l.layer];
    let widest = min(max(l.depth - shadow_depth_in_reach(l), 0.0), half_axis_v.w);
    if share == 0.0 || widest == 0.0 {
        return share;
    }
    let half = shadow_kernel.lookup.size * 0.5;
    let off = vec2f(l.texel.x - half, l.texel.y - half);
    let all = shadow_kernel.blocker_taps + shadow_kernel.filter_taps;
    let turn = shadow_pattern_row(all + (shadow_noise_index(r.pixel.x, r.pixel.y) & shadow_kernel.turns));
    let axes = shadow_turned(shadow_light_axes(shadow_kernel.extent.half_axis_u[l.layer], half_axis_v, off), turn.xy);
    let texel = shadow_texel_depth(shadow_reach_along(shadow_kernel.square, axes));
    var heights = vec3f(1.0, 0.0, 0.0);
    if share < 1.0 {
        heights = shadow_turned_heights(shadow_heights_of_light(r, l.layer, off), turn.xy);
    }
    let s = shadow_Soft(l, i32(shadow_kernel.lookup.size), axes, half_axis_v.w, texel, turn.zw, heights);
    return share * shadow_filtered(s, shadow_mean_nearer(s, widest));
}
