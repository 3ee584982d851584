// The camera's visible surface at a pixel, from the depth buffer.

@group(2) @binding(0) var<uniform> world_from_clip: mat4x4f;
@group(2) @binding(1) var depth_of_pixel: texture_2d<f32>;
@group(2) @binding(2) var normal_of_pixel: texture_2d<f32>;

@vertex fn screen(@builtin(vertex_index) i: u32, @builtin(instance_index) light: u32) -> FullscreenPixel {
    return FullscreenPixel(vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.0, 1.0), light);
}
struct FullscreenPixel {
    @builtin(position) at: vec4f,
    @location(0) @interpolate(flat) light: u32,
}

fn position_at(pixel: vec2f, depth: f32) -> vec3f {
    let share = pixel / vec2f(textureDimensions(depth_of_pixel));
    let point = world_from_clip * vec4f(share.x * 2.0 - 1.0, 1.0 - share.y * 2.0, depth, 1.0);
    return point.xyz / point.w;
}
