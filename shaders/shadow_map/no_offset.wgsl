// In place of offset.wgsl where there is no normal offset.

fn lookup_position(m: ShadowMapUniforms, clip_from_world: mat4x4f, p: vec3f, n: vec3f, n_dot_l: f32) -> vec3f {
    return p;
}
