// import fullscreen_instances
// The filter stage: computes every texel of a layer, whose index is the instance.

@fragment fn umbrage_filter(pixel: UmbragePixel) -> @location(0) vec4f {
    return filter_texel(vec2i(pixel.at.xy), i32(pixel.instance));
}
