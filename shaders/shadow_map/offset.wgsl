// Twin of the normal offset in lookup.rs.

fn lookup_position(m: ShadowMapUniforms, clip_from_world: mat4x4f, p: vec3f, n: vec3f, n_dot_l: f32) -> vec3f {
    let w = transform(clip_from_world, p).w;
    let metres = m.normal_offset * sine(n_dot_l) * (m.texel * w);
    return vec3f(p.x + n.x * metres, p.y + n.y * metres, p.z + n.z * metres);
}
