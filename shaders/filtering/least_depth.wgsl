// Twin of least_depth.rs: the least depth of each tile.

struct LeastDepthUniforms {
    ratio: u32,
    size: u32,
}

fn filter_texel(tile: vec2i, layer: i32) -> vec4f {
    let ratio = i32(kernel.ratio);
    let end = min((tile + 1) * ratio, vec2i(i32(kernel.size)));
    var least = 1.0;
    for (var y = tile.y * ratio; y < end.y; y++) {
        for (var x = tile.x * ratio; x < end.x; x++) {
            least = min(least, stored_depth(vec2i(x, y), layer));
        }
    }
    return vec4f(least, 0.0, 0.0, 0.0);
}
