// Twin of coord.rs: from a receiver to a texel of the map. `layer_at`, `map_layer`, `biased_receiver`, `receiver_gradient`
// and `far_bound` are this map's choices: see choices.rs.

struct ShadowCoord {
    texel: vec2f,
    depth: f32,
    gradient: vec2f,
    deepest: f32,
    layer: i32,
    seen: bool,
}

// The receiver's place, and in w its bias.
fn receiver_with_slope_bias(layer: MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    let n_dot_l = dot3(n, to_light(light, p));
    return vec4f(p, layer.constant + slope_bias(layer.slope, layer.slope_min, n_dot_l));
}

// The same, moved along its normal.
fn receiver_with_normal_offset(layer: MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    let n_dot_l = dot3(n, to_light(light, p));
    let bias = layer.constant + slope_bias(layer.slope, layer.slope_min, n_dot_l);
    return vec4f(offset_along_normal(layer, p, n, n_dot_l), bias);
}

fn shadow_coord(m: ShadowMapUniforms, p: vec3f, n: vec3f) -> ShadowCoord {
    return shadow_coord_in(layer_at(m.light, p), m, p, n);
}

fn shadow_coord_in(index: i32, m: ShadowMapUniforms, p: vec3f, n: vec3f) -> ShadowCoord {
    let layer = map_layer(index);
    let biased = biased_receiver(layer, m.light, p, n);
    let clip = transform(layer.clip_from_world, biased.xyz);
    let point = vec3f(clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    // The texture tells its side for all lanes at once; drivers that run on the CPU read a word of one light among many lane by lane.
    let side = f32(size_0().x);
    let texel = texel_from_point(point, side);
    let gradient = receiver_gradient(layer, point, n, side);
    let depth = point.z - biased.w;
    let deepest = max(depth, layer.deepest_tap);
    let seen = clip.w > 0.0 && point.z <= far_bound(layer);
    return ShadowCoord(texel.xy, depth, gradient, deepest, index, seen);
}
