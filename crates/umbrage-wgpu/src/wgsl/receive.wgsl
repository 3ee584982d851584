// import fullscreen
// The receive stage: calls the kernel for every pixel that receives.

@fragment fn umbrage_receive(@builtin(position) at: vec4f) -> @location(0) f32 {
    let texel = vec2i(at.xy);
    let seen = umbrage_seen(texel);
    if !seen.receives {
        return 1.0;
    }
    return receive(Receiver(seen.position, seen.normal, vec2u(texel), seen.triangle));
}
