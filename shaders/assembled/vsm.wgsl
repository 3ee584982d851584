// Made by umbrage.
struct shadow_Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
@group(0) @binding(0) var<uniform> shadow_kernel: shadow_VsmUniforms;
@group(0) @binding(1) var shadow_image_0: texture_2d<f32>;
fn shadow_load_0(texel: vec2i, layer: i32) -> vec4f { return textureLoad(shadow_image_0, texel, 0); }
fn shadow_size_0() -> vec2i { return vec2i(textureDimensions(shadow_image_0)); }
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

// ---- choice: what no map covers is lit
fn shadow_full_light(r: shadow_Receiver) -> f32 { return 1.0; }

// ---- exp2.wgsl
// Twin of exp2.rs: two to a power, in a fixed order of operations.

fn shadow_power_of_two(exponent: f32) -> f32 {
    let t = min(max(exponent, -126.0), 126.0);
    let whole = floor(t + 0.5);
    let rest = t - whole;
    var sum = 1.5353362e-4;
    sum = sum * rest + 1.3398875e-3;
    sum = sum * rest + 9.618437e-3;
    sum = sum * rest + 5.5503324e-2;
    sum = sum * rest + 2.4022648e-1;
    sum = sum * rest + 6.931472e-1;
    sum = sum * rest + 1.0;
    return bitcast<f32>(bitcast<i32>(sum) + (i32(whole) << 23u));
}

// ---- of_depth.wgsl
// Twin of of_depth.rs: the moments of one depth.

fn shadow_centred(depth: f32) -> f32 {
    return 2.0 * min(max(depth, 0.0), 1.0) - 1.0;
}

fn shadow_variance_moments(depth: f32) -> vec2f {
    let z = shadow_centred(depth);
    return vec2f(z, z * z);
}

fn shadow_exponential_moments(depth: f32, rising: f32, falling: f32) -> vec4f {
    let z = shadow_centred(depth);
    let up = shadow_power_of_two(rising * z);
    let down = shadow_power_of_two(-(falling * z));
    return vec4f(up, up * up, down, down * down);
}

fn shadow_power_moments(depth: f32) -> vec4f {
    let z = shadow_centred(depth);
    let square = z * z;
    return vec4f(z, square, square * z, square * square);
}

// ---- bounds.wgsl
// Twin of bounds.rs: how much light the moments of a neighbourhood's depths allow.

fn shadow_chebyshev(distance: f32, variance: f32) -> f32 {
    return variance / (variance + distance * distance);
}

fn shadow_without_bleeding(lit: f32, amount: f32, scale: f32) -> f32 {
    return min(max((lit - amount) * scale, 0.0), 1.0);
}

fn shadow_lit_by_variance(moments: vec2f, depth: f32, least_variance: f32) -> f32 {
    let distance = depth - moments.x;
    let variance = max(moments.y - moments.x * moments.x, least_variance);
    return select(1.0, shadow_chebyshev(distance, variance), distance > 0.0);
}

fn shadow_lit_by_rising(moments: vec2f, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / receiver;
    let mean = moments.x * scale;
    let variance = max(moments.y * scale * scale - mean * mean, least_variance);
    return select(1.0, shadow_chebyshev(1.0 - mean, variance), moments.x < receiver);
}

fn shadow_lit_by_falling(moments: vec2f, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / moments.x;
    let depth = receiver * scale;
    let variance = max(moments.y * scale * scale - 1.0, least_variance);
    return select(1.0, shadow_chebyshev(1.0 - depth, variance), receiver < moments.x);
}

// ---- choice: moments of 32 bits
fn shadow_stored_moments(moments: vec4f) -> vec4f { return moments; }
fn shadow_loaded_moments(channels: vec4f) -> vec4f { return channels; }

// ---- mipmaps.wgsl
// Twin of mipmaps.rs: how many texels a pixel spans on the map, and which levels of a moment map answer it.

struct shadow_MipmapUniforms {
    levels: u32,
    eye: vec4f,
    axis: vec4f,
}

fn shadow_texels_spanned(eye: vec4f, axis: vec4f, p: vec3f, n: vec3f, n_dot_l: f32, texel: f32) -> f32 {
    let to_eye = vec3f(eye.x - p.x * eye.w, eye.y - p.y * eye.w, eye.z - p.z * eye.w);
    let depth = shadow_dot3(axis.xyz, to_eye);
    let side = depth * axis.w;
    let across_rays = side * side * depth;
    let area = across_rays * abs(n_dot_l) / abs(shadow_dot3(n, to_eye));
    return sqrt(area) / texel;
}

fn shadow_mipmap_level(footprint: f32, levels: u32) -> vec2f {
    var level = 0.0;
    var side = 1.0;
    for (var i = 0u; i < 6u; i++) {
        if i < levels && footprint >= 2.0 * side {
            level += 1.0;
            side *= 2.0;
        }
    }
    if footprint > side && level < f32(levels) {
        return vec2f(level, footprint / side - 1.0);
    }
    return vec2f(level, 0.0);
}

fn shadow_added_variance(level: vec2f) -> f32 {
    let side = f32(1u << u32(level.x));
    return (side * side * (1.0 + 3.0 * level.y) - 1.0) * 0.33333334;
}

// ---- look_up.wgsl
// Twin of look_up.rs: what every kernel with moments does. `lit_by_moments` and `compared_depth` are the technique's, `filtered_moments` is
// the map's choice.

struct shadow_FilteredMoments {
    moments: vec4f,
    // By how much a coarser level spreads the places that are averaged, texels squared.
    spread: f32,
}

// The kernel's first image between its texels.
fn shadow_blended_moments(at: vec2f, layer: i32) -> vec4f {
    let last = shadow_size_0() - 1;
    let place = at - 0.5;
    let corner = floor(place);
    let share = place - corner;
    let first = clamp(vec2i(corner), vec2i(0), last);
    let second = clamp(vec2i(corner) + 1, vec2i(0), last);
    let top_left = shadow_loaded_moments(shadow_load_0(first, layer));
    let top_right = shadow_loaded_moments(shadow_load_0(vec2i(second.x, first.y), layer));
    let bottom_left = shadow_loaded_moments(shadow_load_0(vec2i(first.x, second.y), layer));
    let bottom_right = shadow_loaded_moments(shadow_load_0(second, layer));
    let top = top_left + (top_right - top_left) * share.x;
    let bottom = bottom_left + (bottom_right - bottom_left) * share.x;
    return top + (bottom - top) * share.y;
}

fn shadow_visibility(l: shadow_ShadowCoord, r: shadow_Receiver) -> f32 {
    let size = f32(shadow_size_0().x);
    let is_inside = l.texel.x >= 0.0 && l.texel.y >= 0.0 && l.texel.x < size && l.texel.y < size;
    if shadow_is_lit_beside(!is_inside) {
        return 1.0;
    }
    if l.depth > 1.0 {
        return 0.0;
    }
    let filtered = shadow_filtered_moments(l, r);
    let depth = shadow_centred(shadow_compared_depth(l, filtered.spread));
    let lit = shadow_lit_by_moments(filtered.moments, depth);
    return shadow_without_bleeding(lit, shadow_kernel.bleeding, shadow_kernel.bleeding_scale);
}

// ---- choice: one level
fn shadow_filtered_moments(l: shadow_ShadowCoord, r: shadow_Receiver) -> shadow_FilteredMoments {
    return shadow_FilteredMoments(shadow_blended_moments(l.texel, l.layer), 0.0);
}

// ---- vsm.wgsl
// Twin of vsm.rs: the bound by the mean of depth and of its square.

struct shadow_VsmUniforms {
    lookup: shadow_ShadowMapUniforms,
    mipmaps: shadow_MipmapUniforms,
    bleeding: f32,
    bleeding_scale: f32,
    least_variance: f32,
}

fn shadow_compared_depth(l: shadow_ShadowCoord, spread: f32) -> f32 {
    return l.depth;
}

fn shadow_lit_by_moments(moments: vec4f, depth: f32) -> f32 {
    return shadow_lit_by_variance(moments.xy, depth, shadow_kernel.least_variance);
}
