// Twin of light_plane.rs.

struct LightPlane {
    center: vec3f,
    u: vec3f,
    v: vec3f,
}

fn is_lamp() -> bool {
    let kind = kernel.light.shape.x;
    return kind != LIGHT_DIRECTION && kind != LIGHT_CAP;
}

fn light_plane(o: vec3f) -> LightPlane {
    let s = kernel.light;
    let center = s.center.xyz;
    if !is_lamp() {
        let spread = vec3f(kernel.spread.w);
        return LightPlane(center, product3(s.half_u.xyz, spread), product3(s.half_v.xyz, spread));
    }
    let to_center = center - o;
    let short = vec3f(LIGHT_SHORT);
    let middle = product3(to_center, short);
    if s.shape.x != LIGHT_BALL {
        return LightPlane(middle, product3(s.half_u.xyz, short), product3(s.half_v.xyz, short));
    }
    let n = unit3(to_center);
    let radius = vec3f(s.half_u.w * LIGHT_SHORT);
    return LightPlane(middle, product3(tangent(n), radius), product3(bitangent(n), radius));
}
