// The surfaces of the scene, as seen by the camera.

struct Surface {
    @builtin(position) at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    // w: whether it is paved.
    @location(2) color: vec4f,
}

@vertex fn surface(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) a: vec4f,
    @location(3) b: vec4f,
    @location(4) c: vec4f,
    @location(5) color: vec4f,
) -> Surface {
    let world_from_local = mat3x3f(a.xyz, vec3f(a.w, b.xy), vec3f(b.zw, c.x));
    let world = world_from_local * position + c.yzw;
    // The cofactors turn normals as the inverse transpose does, but for their length.
    let x = world_from_local[0];
    let y = world_from_local[1];
    let z = world_from_local[2];
    let turned = mat3x3f(cross(y, z), cross(z, x), cross(x, y)) * normal;
    return Surface(scene.clip_from_world * vec4f(world, 1.0), world, normalize(turned), color);
}

fn hash(p: vec2f) -> f32 {
    return fract(sin(dot(p, vec2f(12.9898, 78.233))) * 43758.547);
}

// Paving stones of two sizes, with joints that fade where they are narrower than a pixel.
fn stones(p: vec2f) -> f32 {
    let row = floor(p.y / 1.5);
    let shifted = vec2f(p.x + 0.9 * fract(row * 0.5) * 2.0, p.y) / vec2f(1.8, 1.5);
    let cell = floor(shifted);
    let edge = abs(fract(shifted) - 0.5);
    let width = fwidth(shifted);
    let joint = smoothstep(vec2f(0.485) - width, vec2f(0.485), edge) * saturate(0.03 / width);
    let shade = 0.86 + 0.2 * hash(cell);
    return shade * (1.0 - 0.45 * max(joint.x, joint.y));
}

fn albedo(seen: Surface) -> vec3f {
    return seen.color.xyz * mix(1.0, stones(seen.position.xz), seen.color.w);
}
