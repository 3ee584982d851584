@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;

@vertex fn cast_box(
    @location(0) position: vec3f,
    @location(2) a: vec4f,
    @location(3) b: vec4f,
    @location(4) c: vec4f,
) -> @builtin(position) vec4f {
    let world = mat3x3f(a.xyz, vec3f(a.w, b.xy), vec3f(b.zw, c.x)) * position + c.yzw;
    return clip_from_world * vec4f(world, 1.0);
}
