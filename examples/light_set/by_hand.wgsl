// Shadows written for this image alone: four maps in one array, a square of comparisons
// with a constant bias. `RADIUS` is defined in front of this text.

struct Maps {
    clip_from_world: array<mat4x4f, 4>,
    size: f32,
    bias: f32,
}
@group(1) @binding(0) var<uniform> maps: Maps;
@group(1) @binding(1) var depths: texture_2d_array<f32>;

fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    let clip = maps.clip_from_world[light] * vec4f(position, 1.0);
    let point = clip.xyz / clip.w;
    if clip.w <= 0.0 || point.z > 1.0 {
        return 1.0;
    }
    let texel = vec2i(floor(vec2f(point.x * 0.5 + 0.5, 0.5 - point.y * 0.5) * maps.size));
    let size = i32(maps.size);
    let depth = point.z - maps.bias;
    var sum = 0.0;
    for (var y = -RADIUS; y <= RADIUS; y++) {
        for (var x = -RADIUS; x <= RADIUS; x++) {
            let at = texel + vec2i(x, y);
            if any(at < vec2i(0)) || any(at >= vec2i(size)) || depth <= textureLoad(depths, at, light, 0).x {
                sum += 1.0;
            }
        }
    }
    let side = f32(2 * RADIUS + 1);
    return sum / (side * side);
}
