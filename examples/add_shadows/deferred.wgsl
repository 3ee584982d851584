// Depth, normals, and the set's masks, which have a layer for each requested light, in the order of
// the request.
@group(1) @binding(0) var depths: texture_2d<f32>;
@group(1) @binding(1) var normals: texture_2d<f32>;
@group(1) @binding(2) var masks: texture_2d_array<f32>;

@vertex fn screen(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.0, 1.0);
}

@fragment fn shade(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(at.xy);
    let depth = textureLoad(depths, pixel, 0).x;
    if depth == 1.0 {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let size = vec2f(textureDimensions(depths));
    let clip = vec2f(2.0, -2.0) * at.xy / size + vec2f(-1.0, 1.0);
    let world = scene.world_from_clip * vec4f(clip, depth, 1.0);
    let position = world.xyz / world.w;
    let normal = textureLoad(normals, pixel, 0).xyz;
    var light = 0.05;
    for (var i = 0u; i < LAMPS; i++) {
        let visibility = textureLoad(masks, pixel, i, 0).x;
        light += arriving(i, position, normal) * visibility;
    }
    return vec4f(vec3f(0.5 * light), 1.0);
}
