// Alpha-tested triangles. Follows forward.wgsl and the library's alpha test, whose names start with
// `holes_`.

struct Leaf {
    @builtin(position) at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) @interpolate(flat) triangle: u32,
}

@vertex fn place_leaf(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) uv: vec2f, @location(3) triangle: u32) -> Leaf {
    return Leaf(frame.clip_from_world * vec4f(position, 1.0), position, normal, uv, triangle);
}

@fragment fn shade_leaf(leaf: Leaf) -> @location(0) vec4f {
    let r = frame.rays;
    let rays = holes_CameraRays(r[0], r[1], r[2], r[3], r[4], r[5]);
    if holes_is_hole(rays, leaf.at, leaf.triangle) {
        discard;
    }
    return lit(Surface(leaf.at, leaf.position, leaf.normal, leaf.uv));
}
