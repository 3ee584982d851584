// Twin of volumes.rs: lit if in no volume.

struct VolumesUniforms {
    light: vec4f,
}

fn receive(r: Receiver) -> f32 {
    // w is 0 or 1, so its sign bit is never set.
    opaque_zero = bitcast<u32>(kernel.light.w) >> 31u;
    if turned_away(kernel.light, r.position, r.normal) != 0u {
        return 0.0;
    }
    return select(0.0, 1.0, load_0(vec2i(r.pixel), 0).x == 0.0);
}
