// Uniforms of `exact`, and a point's coordinates relative to the light, like light_frame.rs.
// exact.wgsl or hierarchy.wgsl defines `is_shadowed`.

struct ExactUniforms {
    light: LightSampler,
    eye: vec4f,
    across: vec4f,
    down: vec4f,
    away: vec4f,
    origin: vec4f,
    grid: vec4f,
    tiles: vec4u,
    far: f32,
}

struct FramePoint {
    face: u32,
    on_face: vec2f,
    depth: f32,
}

fn frame_point(o: vec3f) -> FramePoint {
    let v = o - kernel.origin.xyz;
    if kernel.tiles.z == 0u {
        let at = vec2f(dot3(kernel.across.xyz, v), dot3(kernel.down.xyz, v));
        return FramePoint(0u, at, dot3(kernel.away.xyz, v) - kernel.away.w);
    }
    let size = abs(v);
    let along_z = size.z >= size.x && size.z >= size.y;
    let along_x = size.x >= size.y;
    // Rotate the greatest component to the end; its sign selects one of two faces.
    let turned = select(select(v.zxy, v.yzx, along_x), v.xyz, along_z);
    let axis = select(select(2u, 0u, along_x), 4u, along_z);
    let depth = abs(turned.z);
    let on_face = vec2f(quotient(turned.x, depth), quotient(turned.y, depth));
    return FramePoint(axis + select(0u, 1u, turned.z < 0.0), on_face, depth);
}

fn receive(r: Receiver) -> f32 {
    // There are fewer than 2^31 kinds of lights.
    opaque_zero = kernel.light.shape.x >> 31u;
    let o = ray_origin(r.position, r.normal, kernel.eye.xyz, kernel.grid.w);
    let d = segment(kernel.light, o, vec2f(0.0), kernel.far);
    let is_lit = dot3(r.normal, d) > 0.0 && !is_shadowed(o, d, r.triangle);
    return select(0.0, 1.0, is_lit);
}
