// import math
// Draws triangles into a light's depth map. Sums are written out and products are guarded, so that
// drivers that keep the order of sums round them alike. Positions are invariant, so that casts with
// different shaders produce equal depths.

@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
@group(1) @binding(0) var<uniform> world_from_local: mat4x4f;

struct Placed {
    @invariant @builtin(position) clip: vec4f,
}

@vertex
fn from_world(@builtin(vertex_index) i: u32, @location(0) p_world: vec3f) -> Placed {
    opaque_zero = i >> 31u;
    return Placed(transform(clip_from_world, p_world));
}

@vertex
fn from_local(@builtin(vertex_index) i: u32, @location(0) p_local: vec3f) -> Placed {
    opaque_zero = i >> 31u;
    return Placed(transform(clip_from_world, transform(world_from_local, p_local).xyz));
}

// The columns of world from local, three components each, are attributes of the instance.
@vertex
fn from_instance(
    @builtin(vertex_index) i: u32,
    @location(0) p_local: vec3f,
    @location(1) a: vec4f,
    @location(2) b: vec4f,
    @location(3) c: vec4f,
) -> Placed {
    opaque_zero = i >> 31u;
    let x = vec4f(a.xyz, 0.0);
    let y = vec4f(a.w, b.xy, 0.0);
    let z = vec4f(b.zw, c.x, 0.0);
    let moved = vec4f(c.yzw, 1.0);
    return Placed(transform(clip_from_world, transform(mat4x4f(x, y, z, moved), p_local).xyz));
}

// Homogeneous: w = 0 is infinitely far away. With w = 1, this rounds like from_world.
@vertex
fn from_homogeneous(@builtin(vertex_index) i: u32, @location(0) v: vec4f) -> Placed {
    opaque_zero = i >> 31u;
    let m = clip_from_world;
    return Placed(product4(m[0], vec4f(v.x)) + product4(m[1], vec4f(v.y)) + product4(m[2], vec4f(v.z)) + product4(m[3], vec4f(v.w)));
}

// ---- depth peeling (Everitt 2001): discard what is not behind the other layer

@group(2) @binding(0) var other: texture_2d<f32>;

@fragment
fn behind(@builtin(position) at: vec4f) {
    if at.z <= textureLoad(other, vec2i(at.xy), 0).x {
        discard;
    }
}

// Compares in integer steps, as stored by the image: a surface must not be behind itself because of
// rounding.
@fragment
fn behind_in_steps(@builtin(position) at: vec4f) {
    if round(at.z * 65535.0) <= round(textureLoad(other, vec2i(at.xy), 0).x * 65535.0) {
        discard;
    }
}
