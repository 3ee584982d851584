// The scene without shadows: its uniforms, the camera's surface, and the unshadowed light.

struct Lamp {
    // Position (w = 1), or direction to the light (w = 0).
    place: vec4f,
    // Axis of a spot; w: brightness.
    axis: vec4f,
    // Cosines of the angles at which full light ends, and at which all light ends.
    cone: vec4f,
}
struct Scene {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    lamps: array<Lamp, LAMPS>,
}
@group(0) @binding(0) var<uniform> scene: Scene;

struct Surface {
    @builtin(position) at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
}

@vertex fn surface(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) a: vec4f,
    @location(3) b: vec4f,
    @location(4) c: vec4f,
) -> Surface {
    let world_from_local = mat3x3f(a.xyz, vec3f(a.w, b.xy), vec3f(b.zw, c.x));
    let world = world_from_local * position + c.yzw;
    return Surface(scene.clip_from_world * vec4f(world, 1.0), world, world_from_local * normal);
}

// Returns the unshadowed light from a lamp.
fn arriving(i: u32, position: vec3f, normal: vec3f) -> f32 {
    let lamp = scene.lamps[i];
    let offset = lamp.place.xyz - position * lamp.place.w;
    let to_light = normalize(offset);
    let facing = max(dot(normal, to_light), 0.0);
    let cone = smoothstep(lamp.cone.y, lamp.cone.x, dot(-to_light, lamp.axis.xyz));
    let falloff = select(1.0, 1.0 / dot(offset, offset), lamp.place.w > 0.0);
    return lamp.axis.w * facing * cone * falloff;
}
