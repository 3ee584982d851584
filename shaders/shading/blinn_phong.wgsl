// Twin of blinn_phong.rs.

struct BlinnPhongUniforms {
    eye: vec4f,
    light: vec4f,
    axis: vec4f,
    color: vec4f,
    ambient: vec4f,
    attenuation: vec4f,
    cone: vec2f,
}

// Returns the vector from p to a point (w = 1), or a direction (w = 0).
fn towards(to: vec4f, p: vec3f) -> vec3f {
    return vec3f(to.x - p.x * to.w, to.y - p.y * to.w, to.z - p.z * to.w);
}

// Returns the linear light that arrives at a point whose geometric normal is n. l is the unit
// direction to the light.
fn arriving(p: vec3f, n: vec3f, l: vec3f, visibility: f32) -> vec3f {
    if dot3(n, l) <= 0.0 {
        return vec3f(0.0, 0.0, 0.0);
    }
    let to_light = towards(kernel.light, p);
    let distance = sqrt(dot3(to_light, to_light));
    let share = cone(dot3(kernel.axis.xyz, l), kernel.cone.x, kernel.cone.y);
    return kernel.color.xyz * (visibility * share * attenuation(kernel.attenuation.xyz, distance));
}

fn shade(r: Receiver, visibility: f32) -> vec4f {
    let s = surface(r.triangle, r.position, r.normal);
    let none = vec3f(0.0, 0.0, 0.0);
    let l = unit_or(towards(kernel.light, r.position), none);
    let v = unit_or(towards(kernel.eye, r.position), none);
    let lit = arriving(r.position, r.normal, l, visibility);
    let share = blinn(s.normal, l, v, s.shininess_log2);
    let reflected = s.diffuse * share.x + s.specular * share.y;
    return vec4f(s.emissive + kernel.ambient.xyz * s.diffuse + lit * reflected, 1.0);
}
