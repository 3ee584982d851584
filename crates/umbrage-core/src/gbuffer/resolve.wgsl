// Twin of resolve.rs: the receiver where a pixel's ray meets a triangle's plane.

struct CameraRays {
    origin: vec4f,
    origin_dx: vec4f,
    origin_dy: vec4f,
    dir: vec4f,
    dir_dx: vec4f,
    dir_dy: vec4f,
}

struct Resolved {
    position: vec3f,
    normal: vec3f,
    t: f32,
}

fn plane_normal(a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    return cross3(b - a, c - a);
}

fn plane_distance(o: vec3f, d: vec3f, a: vec3f, n: vec3f) -> f32 {
    return quotient(dot3(n, a - o), dot3(n, d));
}

fn facing_normal(n: vec3f, d: vec3f) -> vec3f {
    let unit = unit3(n);
    if dot3(n, d) > 0.0 {
        return -unit;
    }
    return unit;
}

fn at_pixel(base: vec4f, dx: vec4f, dy: vec4f, x: u32, y: u32) -> vec3f {
    let fx = f32(x) + 0.5;
    let fy = f32(y) + 0.5;
    return vec3f(
        base.x + product(dx.x, fx) + product(dy.x, fy),
        base.y + product(dx.y, fx) + product(dy.y, fy),
        base.z + product(dx.z, fx) + product(dy.z, fy),
    );
}

// Where the ray is parallel to the plane, abs(t) is not below 3e38 and the pixel counts as empty.
fn resolve(rays: CameraRays, x: u32, y: u32, a: vec3f, b: vec3f, c: vec3f) -> Resolved {
    let o = at_pixel(rays.origin, rays.origin_dx, rays.origin_dy, x, y);
    let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, x, y);
    let n = plane_normal(a, b, c);
    let t = plane_distance(o, d, a, n);
    let position = vec3f(o.x + product(d.x, t), o.y + product(d.y, t), o.z + product(d.z, t));
    return Resolved(position, facing_normal(n, d), t);
}
