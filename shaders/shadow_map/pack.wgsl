// Twin of `PackKernel` in packing.rs. Separate from packing.wgsl, which the twin tests and lookups
// use without an image.

fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
    return pack_depth(load_0(texel, layer).x);
}
