// Made by umbrage.
struct shadow_Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
@group(0) @binding(0) var<uniform> shadow_kernel: shadow_PlanarUniforms;
@group(0) @binding(1) var shadow_image_0: texture_2d_array<f32>;
fn shadow_load_0(texel: vec2i, layer: i32) -> vec4f { return textureLoad(shadow_image_0, texel, layer, 0); }
fn shadow_size_0() -> vec2i { return vec2i(textureDimensions(shadow_image_0)); }
@group(0) @binding(2) var<storage> shadow_table_0: array<vec4u>;
// ---- math.wgsl
// Twin of math.rs: every sum is written out, from left to right.

fn shadow_transform(m: mat4x4f, p: vec3f) -> vec4f {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}

fn shadow_dot3(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn shadow_cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn shadow_unit3(v: vec3f) -> vec3f {
    let length = sqrt(shadow_dot3(v, v));
    return vec3f(v.x / length, v.y / length, v.z / length);
}

// ---- facing.wgsl
// Twin of facing.rs: which way the light is.

fn shadow_turned_away(light: vec4f, p: vec3f, n: vec3f) -> u32 {
    let to_light = vec3f(light.x - p.x * light.w, light.y - p.y * light.w, light.z - p.z * light.w);
    return select(0u, 1u, shadow_dot3(n, to_light) <= 0.0);
}

// ---- planar.wgsl
// Twin of planar.rs: dark where the layer of the pixel's plane (table_0, four triangles a row) is covered.

struct shadow_PlanarUniforms {
    light: vec4f,
    first: u32,
}

const shadow_NO_PLANE = 0xffffffffu;

fn shadow_receive(r: shadow_Receiver) -> f32 {
    if shadow_turned_away(shadow_kernel.light, r.position, r.normal) != 0u {
        return 0.0;
    }
    let i = r.triangle - shadow_kernel.first;
    if i / 4u >= arrayLength(&shadow_table_0) {
        return 1.0;
    }
    let row = shadow_table_0[i / 4u];
    let plane = row[i % 4u];
    if plane == shadow_NO_PLANE {
        return 1.0;
    }
    return select(0.0, 1.0, shadow_load_0(vec2i(r.pixel), i32(plane)).x >= 1.0);
}
