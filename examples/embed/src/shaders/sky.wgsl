// Forward: the sky, where nothing else was drawn.

@fragment fn shade(seen: Triangle) -> @location(0) vec4f {
    return sky_at(seen.clip);
}
