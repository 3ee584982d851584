// import fullscreen_instances, words
// The filter stage of images that store two channels per word.

@fragment fn umbrage_filter(pixel: UmbragePixel) -> @location(0) vec2u {
    return umbrage_words(filter_texel(vec2i(pixel.at.xy), i32(pixel.instance)));
}
