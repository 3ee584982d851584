@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;

struct Cast {
    @builtin(position) at: vec4f,
    @location(0) cloth_at: vec2f,
}

@vertex fn cast_figure(corner: Corner) -> Cast {
    let world = world_from_local(corner.weight) * vec4f(corner.position, 1.0);
    return Cast(clip_from_world * world, corner.cloth_at);
}

@fragment fn discard_holes(seen: Cast) {
    cut_out(seen.cloth_at);
}
