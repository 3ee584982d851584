// Twin of `Blur` in mod.rs.

struct BlurUniforms {
    step: vec2i,
    radius: i32,
    size: i32,
}

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    var sum = vec2f(0.0, 0.0);
    for (var i = -kernel.radius; i <= kernel.radius; i++) {
        let at = clamp(texel + kernel.step * i, vec2i(0), vec2i(kernel.size - 1));
        sum += load_0(at, layer).xy;
    }
    let mean = sum / f32(2 * kernel.radius + 1);
    return vec4f(mean, 0.0, 0.0);
}
