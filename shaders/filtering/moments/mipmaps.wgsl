// Twin of mipmaps.rs: a pixel's footprint on the map, texels, and the levels of a moment map for
// it.

struct MipmapUniforms {
    levels: u32,
    eye: vec4f,
    axis: vec4f,
}

fn texels_spanned(eye: vec4f, axis: vec4f, p: vec3f, n: vec3f, n_dot_l: f32, texel: f32) -> f32 {
    let to_eye = vec3f(eye.x - p.x * eye.w, eye.y - p.y * eye.w, eye.z - p.z * eye.w);
    let depth = dot3(axis.xyz, to_eye);
    let side = depth * axis.w;
    let across_rays = side * side * depth;
    let area = across_rays * abs(n_dot_l) / abs(dot3(n, to_eye));
    return sqrt(area) / texel;
}

fn mipmap_level(footprint: f32, levels: u32) -> vec2f {
    var level = 0.0;
    var side = 1.0;
    for (var i = 0u; i < 6u; i++) {
        if i < levels && footprint >= 2.0 * side {
            level += 1.0;
            side *= 2.0;
        }
    }
    if footprint > side && level < f32(levels) {
        return vec2f(level, footprint / side - 1.0);
    }
    return vec2f(level, 0.0);
}

fn added_variance(level: vec2f) -> f32 {
    let side = f32(1u << u32(level.x));
    return (side * side * (1.0 + 3.0 * level.y) - 1.0) * 0.33333334;
}
