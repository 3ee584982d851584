// Twin of blur.rs: the mean of the texels along a row or a column.

struct BoxBlurUniforms {
    radius: i32,
    step: vec2i,
    share: f32,
}

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    let last = size_0() - 1;
    var sum = vec4f(0.0);
    for (var i = -kernel.radius; i <= kernel.radius; i++) {
        let at = clamp(texel + kernel.step * i, vec2i(0), last);
        sum += loaded_moments(load_0(at, layer));
    }
    return stored_moments(sum * kernel.share);
}
