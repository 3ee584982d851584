// Draws normals for the deferred renderers; depth is written along. It stands behind the scene's text.

@fragment fn store_normal(seen: Surface) -> @location(0) vec4f {
    return vec4f(normalize(seen.normal), 0.0);
}
