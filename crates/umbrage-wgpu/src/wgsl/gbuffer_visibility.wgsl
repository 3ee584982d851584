// import math, resolve
// The visible triangle id of each pixel: the nearest, and the first of equally near ones.

struct Seen {
    clip_from_world: mat4x4f,
    rays: CameraRays,
    first_receiver: u32,
    end_receiver: u32,
}

@group(0) @binding(0) var<uniform> seen: Seen;
@group(0) @binding(1) var<storage> positions: array<f32>;
@group(0) @binding(2) var<storage> indices: array<u32>;

fn corner(i: u32) -> vec3f {
    let v = 3u * indices[i];
    return vec3f(positions[v], positions[v + 1u], positions[v + 2u]);
}

struct Vertex {
    @invariant @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
}

@vertex
fn show(@builtin(vertex_index) i: u32) -> Vertex {
    opaque_zero = i >> 31u;
    return Vertex(transform(seen.clip_from_world, corner(i)), i / 3u);
}

@fragment
fn write_id(v: Vertex) -> @location(0) u32 {
    return v.triangle;
}
