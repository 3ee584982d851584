// What all shaders of the program share: the scene's numbers, the sky, and how colours become a picture.

struct Lamp {
    // Position (w = 1), or direction to the light (w = 0).
    place: vec4f,
    // The way a spot points; w: cosine of the angle where its light ends.
    axis: vec4f,
    // w: where its light has faded away, metres.
    color: vec4f,
    // x: cosine of the angle of full light.
    cone: vec4f,
}
struct Scene {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    // w: number of lamps.
    eye: vec4f,
    // Direction to the sun.
    sun: vec4f,
    // By the lights' indices in the set.
    lamps: array<Lamp, 16>,
}
@group(0) @binding(0) var<uniform> scene: Scene;

const HORIZON = vec3f(0.62, 0.56, 0.54);

fn sky(direction: vec3f) -> vec3f {
    let height = max(direction.y, 0.0);
    let blue = mix(HORIZON, vec3f(0.13, 0.26, 0.5), 1.0 - exp(-4.0 * height));
    let glow = pow(max(dot(direction, scene.sun.xyz), 0.0), 12.0);
    return blue + glow * vec3f(0.5, 0.3, 0.12);
}

// A curve for film by Narkowicz 2015, "ACES filmic tone mapping curve".
fn tone(color: vec3f) -> vec3f {
    let c = 0.6 * color;
    return saturate(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14));
}

// Targets that don't encode sRGB themselves get encoded colours.
override encodes: bool = false;

fn picture(color: vec3f) -> vec4f {
    let linear = tone(color);
    if !encodes {
        return vec4f(linear, 1.0);
    }
    let low = linear * 12.92;
    let high = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return vec4f(select(high, low, linear <= vec3f(0.0031308)), 1.0);
}

struct Triangle {
    @builtin(position) at: vec4f,
    @location(0) clip: vec2f,
}

// A triangle around the screen, as far away as can be: depth is reversed.
@vertex fn screen(@builtin(vertex_index) i: u32) -> Triangle {
    let clip = vec2f(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0);
    return Triangle(vec4f(clip, 0.0, 1.0), clip);
}

fn world_at(clip: vec2f, depth: f32) -> vec3f {
    let p = scene.world_from_clip * vec4f(clip, depth, 1.0);
    return p.xyz / p.w;
}

fn sky_at(clip: vec2f) -> vec4f {
    return picture(sky(normalize(world_at(clip, 0.5) - scene.eye.xyz)));
}
