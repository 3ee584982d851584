// Twin of `BetweenKernel` in between.rs: the mean of two depths.

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    let middle = (load_0(texel, layer).x + load_1(texel, layer).x) * 0.5;
    return vec4f(middle, 0.0, 0.0, 0.0);
}
