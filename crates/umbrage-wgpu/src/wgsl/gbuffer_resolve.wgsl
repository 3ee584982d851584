// import gbuffer_visibility, fullscreen
// Computes receivers from triangle ids. normal.w is the distance in multiples of the ray's
// direction.

@group(0) @binding(3) var triangle: texture_2d<u32>;

struct Receivers {
    @location(0) position: vec4f,
    @location(1) normal: vec4f,
}

@fragment
fn resolve_pixel(@builtin(position) at: vec4f) -> Receivers {
    opaque_zero = seen.first_receiver >> 31u;
    let pixel = vec2u(at.xy);
    let id = textureLoad(triangle, vec2i(pixel), 0).x;
    if id == 0xffffffffu {
        return Receivers(vec4f(), vec4f());
    }
    let r = resolve(seen.rays, pixel.x, pixel.y, corner(3u * id), corner(3u * id + 1u), corner(3u * id + 2u));
    if !(abs(r.t) < 3e38) {
        return Receivers(vec4f(), vec4f(0.0, 0.0, 0.0, 3.4e38));
    }
    let receives = select(0.0, 1.0, id >= seen.first_receiver && id < seen.end_receiver);
    return Receivers(vec4f(r.position, receives), vec4f(r.normal, r.t));
}
