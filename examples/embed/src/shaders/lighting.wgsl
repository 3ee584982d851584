// How a surface is lit. `visibility`, the share of a lamp that a surface sees, is another text's: forward it asks the light set, deferred
// it reads a mask.

// Light that arrives from everywhere: from the sky above, from the ground below.
fn ambient(normal: vec3f) -> vec3f {
    return mix(vec3f(0.11, 0.09, 0.075), vec3f(0.17, 0.21, 0.29), 0.5 + 0.5 * normal.y);
}

// The share of a lamp's light that arrives, shadows apart.
fn strength(lamp: Lamp, offset: vec3f, to_light: vec3f) -> f32 {
    if lamp.place.w == 0.0 {
        return 1.0;
    }
    // Inverse squares that end at the lamp's range: Karis 2013, "Real shading in Unreal Engine 4".
    let squared = dot(offset, offset);
    let share = squared / (lamp.color.w * lamp.color.w);
    let window = saturate(1.0 - share * share);
    let cone = smoothstep(lamp.axis.w, lamp.cone.x, dot(-to_light, lamp.axis.xyz));
    return window * window * cone / (squared + 1.0);
}

fn lit_color(position: vec3f, normal: vec3f, albedo: vec3f, pixel: vec2u) -> vec3f {
    let to_eye = scene.eye.xyz - position;
    let view = normalize(to_eye);
    var color = albedo * ambient(normal);
    for (var i = 0u; i < u32(scene.eye.w); i++) {
        let lamp = scene.lamps[i];
        let offset = lamp.place.xyz - position * lamp.place.w;
        let to_light = normalize(offset);
        let facing = dot(normal, to_light);
        if facing <= 0.0 {
            continue;
        }
        let arriving = facing * strength(lamp, offset, to_light);
        if arriving <= 0.0 {
            continue;
        }
        let half_way = normalize(to_light + view);
        let gloss = 0.12 * pow(max(dot(normal, half_way), 0.0), 32.0);
        color += lamp.color.xyz * (albedo + gloss) * (arriving * visibility(i, position, normal, pixel));
    }
    let haze = 1.0 - exp(-0.004 * length(to_eye));
    return mix(color, HORIZON, haze);
}
