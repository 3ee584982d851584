// Twin of layers.rs: a shadow map's layers, and the cube face of a receiver.

// Values of `ARRANGEMENT`: see variants.rs.
const SINGLE_MAP = 0u;
const CUBE = 1u;
const CASCADED_MAPS = 2u;

struct MapLayer {
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
    deepest: f32,
}

struct ShadowMapUniforms {
    layer_count: u32,
    packed: u32,
    clamped: u32,
    pick_reach: f32,
    blend: f32,
    layers: array<MapLayer, 8>,
    light: vec4f,
    size: f32,
    sample_gain: f32,
}

struct MapOnlyUniforms {
    lookup: ShadowMapUniforms,
}

fn cube_face(light: vec4f, p: vec3f) -> i32 {
    let d = vec3f(p.x - light.x, p.y - light.y, p.z - light.z);
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(1, 0, d.x >= 0.0);
    }
    let negative = vec2i(bitcast<vec2u>(d.yz) >> vec2u(31u, 31u));
    return select(4 + negative.y, 2 + negative.x, a.y >= a.z);
}
