// Twin of `cube_face` in lookup.rs.

fn cube_face(light: vec4f, p: vec3f) -> i32 {
    let d = vec3f(p.x - light.x, p.y - light.y, p.z - light.z);
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(1, 0, d.x >= 0.0);
    }
    let negative = vec2i(bitcast<vec2u>(d.yz) >> vec2u(31u, 31u));
    return select(4 + negative.y, 2 + negative.x, a.y >= a.z);
}

fn lookup_layer(m: ShadowMapUniforms, p: vec3f) -> i32 {
    return cube_face(m.light, p);
}

// Spelled out: an index that varies would make drivers copy the whole struct.
fn lookup_face(m: ShadowMapUniforms, layer: i32) -> mat4x4f {
    switch layer {
        case 0: { return m.faces[0]; }
        case 1: { return m.faces[1]; }
        case 2: { return m.faces[2]; }
        case 3: { return m.faces[3]; }
        case 4: { return m.faces[4]; }
        default: { return m.faces[5]; }
    }
}
