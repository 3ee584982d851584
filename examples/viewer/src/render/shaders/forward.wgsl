// Lit surfaces. The light set's text, which precedes this one, defines `shadow`.

struct Lamp {
    // Position (w = 1), or direction to the light (w = 0).
    place: vec4f,
    // Axis of a spot; w: cosine of the angle where its light ends.
    axis: vec4f,
    // Linear colour; w: the light's index in the set.
    color: vec4f,
    // x: cosine of the angle of a spot's full light.
    cone: vec4f,
}
struct Frame {
    clip_from_world: mat4x4f,
    // w: number of lamps.
    eye: vec4f,
    // Ambient light: from above, from below.
    sky: vec4f,
    ground: vec4f,
    // Rays through the pixels: the fields of the library's `CameraRays`.
    rays: array<vec4f, 6>,
    lamps: array<Lamp, 16>,
}
struct Material {
    diffuse: vec4f,
    // w: the highlight's power.
    specular: vec4f,
    emissive: vec4f,
}
@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var colors: texture_2d<f32>;
@group(1) @binding(2) var color_sampler: sampler;

struct Surface {
    @builtin(position) at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
}

@vertex fn place(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) uv: vec2f) -> Surface {
    return Surface(frame.clip_from_world * vec4f(position, 1.0), position, normal, uv);
}

// Returns the fraction of a lamp's light within its cone.
fn cone_of(lamp: Lamp, to_light: vec3f) -> f32 {
    return smoothstep(lamp.axis.w, lamp.cone.x, dot(-to_light, lamp.axis.xyz));
}

fn lit(seen: Surface) -> vec4f {
    let to_eye = frame.eye.xyz - seen.position;
    let view = normalize(to_eye);
    // The triangle's geometric normal on the visible side, for the shadow lookup.
    var flat_normal = normalize(cross(dpdx(seen.position), dpdy(seen.position)));
    flat_normal *= select(-1.0, 1.0, dot(flat_normal, view) > 0.0);
    var normal = normalize(seen.normal);
    normal *= select(-1.0, 1.0, dot(normal, flat_normal) > 0.0);
    let albedo = material.diffuse.xyz * textureSample(colors, color_sampler, seen.uv).xyz;
    var color = material.emissive.xyz + albedo * mix(frame.ground.xyz, frame.sky.xyz, 0.5 + 0.5 * normal.y);
    for (var i = 0u; i < u32(frame.eye.w); i++) {
        let lamp = frame.lamps[i];
        let to_light = normalize(lamp.place.xyz - seen.position * lamp.place.w);
        let facing = dot(normal, to_light);
        if facing <= 0.0 || dot(flat_normal, to_light) <= 0.0 {
            continue;
        }
        let arriving = facing * cone_of(lamp, to_light);
        if arriving <= 0.0 {
            continue;
        }
        let visible = shadow(u32(lamp.color.w), seen.position, flat_normal, vec2u(seen.at.xy));
        let half_way = normalize(to_light + view);
        let gloss = material.specular.xyz * pow(max(dot(normal, half_way), 0.0), material.specular.w);
        color += lamp.color.xyz * (albedo + gloss) * (arriving * visible);
    }
    return vec4f(color, 1.0);
}

@fragment fn shade(seen: Surface) -> @location(0) vec4f {
    return lit(seen);
}
