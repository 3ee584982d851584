// Bindings of the alpha test, in a group of the caller.

@group(UMBRAGE_GROUP) @binding(0) var<storage> positions: array<f32>;
@group(UMBRAGE_GROUP) @binding(1) var<storage> indices: array<u32>;
@group(UMBRAGE_GROUP) @binding(2) var<storage> cut_outs: array<vec4u>;

fn corner(i: u32) -> vec3f {
    let v = 3u * indices[i];
    return vec3f(positions[v], positions[v + 1u], positions[v + 2u]);
}
