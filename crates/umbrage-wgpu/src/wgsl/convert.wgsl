// import fullscreen
// Full-screen copies of one layer: to plain floats as shaders load them, and from plain floats to
// depth.

@group(0) @binding(0) var source: texture_2d<f32>;

@fragment
fn load_texel(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return textureLoad(source, vec2i(at.xy), 0);
}

@fragment
fn write_depth(@builtin(position) at: vec4f) -> @builtin(frag_depth) f32 {
    return textureLoad(source, vec2i(at.xy), 0).x;
}
