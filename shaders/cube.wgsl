// Twin of `cube_face` in shadow_map.rs.

fn cube_face(light: vec4f, p: vec3f) -> i32 {
    let d = vec3f(p.x - light.x, p.y - light.y, p.z - light.z);
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(1, 0, d.x >= 0.0);
    }
    if a.y >= a.z {
        return select(3, 2, d.y >= 0.0);
    }
    return select(5, 4, d.z >= 0.0);
}

fn lookup_layer(m: MapLookup, p: vec3f) -> i32 {
    return cube_face(m.light, p);
}
