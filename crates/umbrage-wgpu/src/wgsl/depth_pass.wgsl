// import depth, fullscreen
// Writes a G-buffer from a depth buffer.

@fragment fn unproject_pixel(@builtin(position) at: vec4f) -> Surface {
    return surface_at(vec2i(at.xy));
}
