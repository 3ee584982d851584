// Twin of coord.rs: from a receiver to a texel of the map.

// Values of `BIAS`: see variants.rs.
const CONSTANT_BIAS = 0u;
const SLOPE_BIAS = 1u;
const NORMAL_OFFSET = 2u;

// Values of `BEYOND_FAR`.
const CLAMPED_BEYOND_FAR = 0u;
const LIT_BEYOND_FAR = 1u;
const COMPARED_BEYOND_FAR = 2u;

struct ShadowCoord {
    texel: vec2f,
    depth: f32,
    gradient: vec2f,
    deepest: f32,
    layer: i32,
    covered: bool,
}

// Returns the receiver's position (xyz) and its bias (w).
fn biased_receiver(layer: MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    if BIAS == CONSTANT_BIAS {
        return vec4f(p, layer.constant);
    }
    let n_dot_l = dot3(n, to_light(light, p));
    let bias = layer.constant + slope_bias(layer.slope, layer.slope_min, n_dot_l);
    if BIAS == NORMAL_OFFSET {
        return vec4f(offset_along_normal(layer, p, n, n_dot_l), bias);
    }
    return vec4f(p, bias);
}

fn receiver_gradient(layer: MapLayer, point: vec3f, n: vec3f, size: f32) -> vec2f {
    if TAPS_FOLLOW_PLANE {
        return plane_gradient(layer.clip_from_world, point, n, size, layer.receiver_plane);
    }
    return vec2f(0.0, 0.0);
}

// Returns the greatest clip depth of receivers that are compared.
fn far_bound(layer: MapLayer) -> f32 {
    if BEYOND_FAR == LIT_BEYOND_FAR {
        return 1.0;
    }
    return layer.far;
}

fn deepest_depth(layer: MapLayer, depth: f32) -> f32 {
    let deepest = max(depth, layer.deepest_tap);
    if BEYOND_FAR == CLAMPED_BEYOND_FAR {
        return min(deepest, 1.0);
    }
    return deepest;
}

// Returns the clip depth to compare at the receiver itself.
fn own_depth(l: ShadowCoord) -> f32 {
    if BEYOND_FAR == CLAMPED_BEYOND_FAR {
        return min(l.depth, l.deepest);
    }
    return l.depth;
}

fn shadow_coord(m: ShadowMapUniforms, p: vec3f, n: vec3f) -> ShadowCoord {
    return shadow_coord_in(layer_at(m.light, p), m, p, n);
}

fn shadow_coord_in(index: i32, m: ShadowMapUniforms, p: vec3f, n: vec3f) -> ShadowCoord {
    let layer = map_layer(index);
    let biased = biased_receiver(layer, m.light, p, n);
    let clip = transform(layer.clip_from_world, biased.xyz);
    let point = vec3f(clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    // Query the texture's size, which is uniform for all lanes. Drivers that run on the CPU read a
    // word of one light among many lane by lane.
    let side = f32(size_0().x);
    let texel = texel_from_point(point, side);
    let gradient = receiver_gradient(layer, point, n, side);
    let depth = point.z - biased.w;
    let deepest = deepest_depth(layer, depth);
    let covered = clip.w > 0.0 && point.z <= far_bound(layer);
    return ShadowCoord(texel.xy, depth, gradient, deepest, index, covered);
}
