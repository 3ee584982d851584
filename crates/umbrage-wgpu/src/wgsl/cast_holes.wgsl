// import cast, holes
// Draws alpha-tested triangles into a light's depth map, from the geometry's own lists, at the
// positions of cast.wgsl.

@group(1) @binding(0) var<uniform> rays: CameraRays;
@group(1) @binding(1) var<storage> positions: array<f32>;
@group(1) @binding(2) var<storage> indices: array<u32>;
@group(1) @binding(3) var<storage> cut_outs: array<vec4u>;

fn corner(i: u32) -> vec3f {
    let v = 3u * indices[i];
    return vec3f(positions[v], positions[v + 1u], positions[v + 2u]);
}

struct PlacedTriangle {
    @invariant @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
}

@vertex
fn from_list(@builtin(vertex_index) i: u32) -> PlacedTriangle {
    opaque_zero = i >> 31u;
    return PlacedTriangle(transform(clip_from_world, corner(i)), i / 3u);
}

@fragment
fn not_in_hole(v: PlacedTriangle) {
    if is_hole(rays, v.clip, v.triangle) {
        discard;
    }
}

@fragment
fn behind_and_not_in_hole(v: PlacedTriangle) {
    if v.clip.z <= textureLoad(other, vec2i(v.clip.xy), 0).x || is_hole(rays, v.clip, v.triangle) {
        discard;
    }
}

@fragment
fn behind_in_steps_and_not_in_hole(v: PlacedTriangle) {
    let before = round(v.clip.z * 65535.0) <= round(textureLoad(other, vec2i(v.clip.xy), 0).x * 65535.0);
    if before || is_hole(rays, v.clip, v.triangle) {
        discard;
    }
}
