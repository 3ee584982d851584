// Twin of `Moments` in mod.rs.

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    let depth = load_0(texel, layer).x;
    return vec4f(depth, depth * depth, 0.0, 0.0);
}
