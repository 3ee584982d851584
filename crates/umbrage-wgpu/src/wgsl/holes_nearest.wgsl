// import holes
// Tests whether a pixel is in a hole of a triangle, if all alpha textures use the nearest texel.

fn is_hole(rays: CameraRays, at: vec4f, triangle: u32) -> bool {
    opaque_zero = triangle >> 31u;
    let pixel = vec2u(at.xy);
    let o = at_pixel(rays.origin, rays.origin_dx, rays.origin_dy, pixel.x, pixel.y);
    let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, pixel.x, pixel.y);
    let a = corner(3u * triangle);
    let b = corner(3u * triangle + 1u);
    let c = corner(3u * triangle + 2u);
    return is_hole_met(o, d, a, b, c, record_of(triangle));
}
