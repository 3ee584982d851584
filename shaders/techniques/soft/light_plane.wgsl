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
        return LightPlane(center, s.half_u.xyz * kernel.spread.w, s.half_v.xyz * kernel.spread.w);
    }
    let to_center = center - o;
    let middle = product3(to_center, vec3f(LIGHT_SHORT));
    if s.shape.x != LIGHT_BALL {
        return LightPlane(middle, s.half_u.xyz * LIGHT_SHORT, s.half_v.xyz * LIGHT_SHORT);
    }
    let n = unit3(to_center);
    let radius = s.half_u.w * LIGHT_SHORT;
    return LightPlane(middle, tangent(n) * radius, bitangent(n) * radius);
}
