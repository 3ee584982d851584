// Draws casters into a light's depth map. Sums are written out, so that every driver rounds them alike.

@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
@group(1) @binding(0) var<uniform> world_from_local: mat4x4f;

@vertex
fn from_world(@location(0) p_world: vec3f) -> @builtin(position) vec4f {
    return transform(clip_from_world, p_world);
}

@vertex
fn from_local(@location(0) p_local: vec3f) -> @builtin(position) vec4f {
    return transform(clip_from_world, transform(world_from_local, p_local).xyz);
}
