// import holes, hashed_alpha, hashed_hole
// Tests whether a pixel is in a hole of a triangle, if an alpha texture is mipmapped and hashed.
// Needs `coverage`, the table of hashed_alpha.rs.

fn coverage_row(i: u32) -> vec4u {
    return coverage[i];
}

struct PixelRay {
    o: vec3f,
    d: vec3f,
}

fn pixel_ray(rays: CameraRays, x: u32, y: u32) -> PixelRay {
    let o = at_pixel(rays.origin, rays.origin_dx, rays.origin_dy, x, y);
    let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, x, y);
    return PixelRay(o, d);
}

fn is_hole(rays: CameraRays, at: vec4f, triangle: u32) -> bool {
    opaque_zero = triangle >> 31u;
    let pixel = vec2u(at.xy);
    let ray = pixel_ray(rays, pixel.x, pixel.y);
    let a = corner(3u * triangle);
    let b = corner(3u * triangle + 1u);
    let c = corner(3u * triangle + 2u);
    let record = record_of(triangle);
    let number = (record - 1u) / 2u;
    let heads = coverage_row(number / 4u);
    let levels = heads[number % 4u];
    if levels == 0u {
        return is_hole_met(ray.o, ray.d, a, b, c, record);
    }
    let uv_ab = bitcast<vec4f>(cut_out_row(record));
    let rest = cut_out_row(record + 1u);
    let uv_c = bitcast<vec2f>(rest.xy);
    let size = vec2u(rest.z & 0xffffu, rest.z >> 16u);
    let ray_right = pixel_ray(rays, pixel.x + 1u, pixel.y);
    let ray_below = pixel_ray(rays, pixel.x, pixel.y + 1u);
    let uv = uv_met(ray.o, ray.d, a, b, c, uv_ab, uv_c);
    let right = uv_met(ray_right.o, ray_right.d, a, b, c, uv_ab, uv_c);
    let below = uv_met(ray_below.o, ray_below.d, a, b, c, uv_ab, uv_c);
    let squared = squared_footprint(uv, right, below, size);
    if squared > 1.0 {
        return is_hashed_hole(uv, squared, levels, rest.w, triangle);
    }
    return is_hole_met(ray.o, ray.d, a, b, c, record);
}
