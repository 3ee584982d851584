// import math
// Computes a G-buffer from a depth buffer: positions by unprojection, geometric normals from
// neighbouring pixels.

struct DepthCamera {
    world_from_clip: mat4x4f,
    empty: f32,
    handedness: f32,
}

struct Surface {
    @location(0) position: vec4f,
    @location(1) normal: vec4f,
}

@group(UMBRAGE_GROUP) @binding(0) var<uniform> camera: DepthCamera;

fn load_depth(pixel: vec2i) -> f32 {
    return textureLoad(depth_texture, pixel, 0).x;
}

fn depth_size() -> vec2i {
    return vec2i(textureDimensions(depth_texture));
}

fn depth_at(pixel: vec2i) -> f32 {
    return load_depth(clamp(pixel, vec2i(0), depth_size() - 1));
}

fn unproject(pixel: vec2i, depth: f32) -> vec3f {
    // Set from the last bit of 0, -0 or 1.
    opaque_zero = bitcast<u32>(camera.empty) & 1u;
    let uv = (vec2f(pixel) + 0.5) / vec2f(depth_size());
    let p = transform(camera.world_from_clip, vec3f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, depth));
    return p.xyz / p.w;
}

// Returns the step to one of the two neighbours along an axis. Depth is linear along a plane in
// screen space, so the neighbour whose depth continues linearly is on the same surface. The other
// may be beyond an edge.
fn tangent(pixel: vec2i, p: vec3f, depth: f32, axis: vec2i) -> vec3f {
    let before = depth_at(pixel - axis);
    let after = depth_at(pixel + axis);
    let miss_before = abs(2.0 * before - depth_at(pixel - 2 * axis) - depth);
    let miss_after = abs(2.0 * after - depth_at(pixel + 2 * axis) - depth);
    let limit = depth_size() - 1;
    let no_after = any(pixel + axis > limit) || after == camera.empty;
    let no_before = any(pixel < axis) || before == camera.empty;
    if no_after || (!no_before && miss_before < miss_after) {
        return p - unproject(pixel - axis, before);
    }
    return unproject(pixel + axis, after) - p;
}

fn surface_at(pixel: vec2i) -> Surface {
    let depth = load_depth(pixel);
    if depth == camera.empty {
        return Surface(vec4f(), vec4f());
    }
    let p = unproject(pixel, depth);
    let right = tangent(pixel, p, depth, vec2i(1, 0));
    let down = tangent(pixel, p, depth, vec2i(0, 1));
    // For a right-handed camera, right x up points to the viewer, however the surface is inclined.
    let normal = unit3(cross3(down, right)) * camera.handedness;
    return Surface(vec4f(p, 1.0), vec4f(normal, 0.0));
}
