// A scene with four lights. `lit` is another text's: that of the light set, or one written by hand.

struct SceneLight {
    // Position (w = 1), or direction to the light (w = 0).
    place: vec4f,
    color: vec4f,
}
struct Scene {
    clip_from_world: mat4x4f,
    lights: array<SceneLight, 4>,
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
    let linear = mat3x3f(a.xyz, vec3f(a.w, b.xy), vec3f(b.zw, c.x));
    let world = linear * position + c.yzw;
    return Surface(scene.clip_from_world * vec4f(world, 1.0), world, linear * normal);
}

@fragment fn shade(seen: Surface) -> @location(0) vec4f {
    return shade_surface(seen.position, normalize(seen.normal), vec2u(seen.at.xy));
}

fn shade_surface(position: vec3f, normal: vec3f, pixel: vec2u) -> vec4f {
    var color = vec3f(0.03);
    for (var i = 0u; i < 4u; i++) {
        let light = scene.lights[i];
        let offset = light.place.xyz - position * light.place.w;
        let facing = dot(normal, normalize(offset));
        if facing > 0.0 {
            let falloff = select(1.0, 1.0 / (1.0 + 0.02 * dot(offset, offset)), light.place.w > 0.0);
            color += light.color.xyz * (facing * falloff * lit(i, position, normal, pixel));
        }
    }
    return vec4f(color, 1.0);
}
