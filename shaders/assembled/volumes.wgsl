// Made by umbrage.
struct shadow_Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
@group(0) @binding(0) var<uniform> shadow_kernel: shadow_VolumesUniforms;
@group(0) @binding(1) var shadow_image_0: texture_2d<u32>;
fn shadow_load_0(texel: vec2i, layer: i32) -> vec4f { return vec4f(f32(textureLoad(shadow_image_0, texel, 0).x), 0.0, 0.0, 0.0); }
fn shadow_size_0() -> vec2i { return vec2i(textureDimensions(shadow_image_0)); }
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

// ---- volumes.wgsl
// Twin of volumes.rs: lit if in no volume.

struct shadow_VolumesUniforms {
    light: vec4f,
}

fn shadow_receive(r: shadow_Receiver) -> f32 {
    if shadow_turned_away(shadow_kernel.light, r.position, r.normal) != 0u {
        return 0.0;
    }
    return select(0.0, 1.0, shadow_load_0(vec2i(r.pixel), 0).x == 0.0);
}
