// Figures that the program draws itself. The shaders of both passes follow: casts have the light's
// matrix at group 0, shading has the scene there.

struct Figure {
    // Placement of each bone.
    bones: array<mat4x4f, 2>,
}
@group(3) @binding(0) var<uniform> figure: Figure;
@group(3) @binding(1) var cloth: texture_2d<f32>;
@group(3) @binding(2) var cloth_sampler: sampler;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) cloth_at: vec2f,
    // Share of the second bone.
    @location(3) weight: f32,
}

fn world_from_local(weight: f32) -> mat4x4f {
    return figure.bones[0] * (1.0 - weight) + figure.bones[1] * weight;
}

// Discards the holes of the cloth.
fn cut_out(cloth_at: vec2f) {
    if textureSample(cloth, cloth_sampler, cloth_at).x < 0.5 {
        discard;
    }
}
