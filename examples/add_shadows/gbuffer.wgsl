@fragment fn store(seen: Surface) -> @location(0) vec4f {
    return vec4f(normalize(seen.normal), 0.0);
}
