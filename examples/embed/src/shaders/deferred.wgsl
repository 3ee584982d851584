// Deferred, second half: the screen is lit from the G-buffer and the set's masks, one layer a light.

@group(1) @binding(0) var depths: texture_depth_2d;
@group(1) @binding(1) var albedos: texture_2d<f32>;
@group(1) @binding(2) var normals: texture_2d<f32>;
@group(1) @binding(3) var masks: texture_2d_array<f32>;

fn visibility(lamp: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    return textureLoad(masks, pixel, lamp, 0).x;
}

@fragment fn shade(seen: Triangle) -> @location(0) vec4f {
    let pixel = vec2u(seen.at.xy);
    let depth = textureLoad(depths, pixel, 0);
    if depth == 0.0 {
        return sky_at(seen.clip);
    }
    let position = world_at(seen.clip, depth);
    let normal = normalize(2.0 * textureLoad(normals, pixel, 0).xyz - 1.0);
    let albedo = textureLoad(albedos, pixel, 0).xyz;
    return picture(lit_color(position, normal, albedo, pixel));
}
