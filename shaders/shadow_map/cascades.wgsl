// Twin of the functions in cascades.rs that read no data: the distance of a receiver inside a
// cascade, and blending.

fn room_around(clip_from_world: mat4x4f, p: vec3f, size: f32) -> vec2f {
    let clip = transform(clip_from_world, p);
    let point = vec3f(clip.x / clip.w, clip.y / clip.w, clip.z / clip.w);
    let texel = texel_from_point(point, size);
    let across = min(texel.x, size - texel.x);
    let down = min(texel.y, size - texel.y);
    return vec2f(min(across, down), 1.0 - point.z);
}

fn is_held(room: vec2f, reach: f32) -> bool {
    return room.x > reach && room.y >= 0.0;
}

fn own_share(room: vec2f, reach: f32, depth_in_texels: f32, blend: f32) -> f32 {
    let inside = min(room.x - reach, room.y * depth_in_texels);
    return min(max(inside / blend, 0.0), 1.0);
}

fn blended(own: f32, next: f32, share: f32) -> f32 {
    return own * share + next * (1.0 - share);
}
