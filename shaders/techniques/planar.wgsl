// Twin of planar.rs: dark if the layer of the pixel's plane (table_0, four triangles per row) is
// covered.

struct PlanarUniforms {
    light: vec4f,
    first: u32,
}

const NO_PLANE = 0xffffffffu;

fn receive(r: Receiver) -> f32 {
    // w is 0 or 1, so its sign bit is never set.
    opaque_zero = bitcast<u32>(kernel.light.w) >> 31u;
    if turned_away(kernel.light, r.position, r.normal) != 0u {
        return 0.0;
    }
    let i = r.triangle - kernel.first;
    if i / 4u >= arrayLength(&table_0) {
        return 1.0;
    }
    let row = table_0[i / 4u];
    let plane = row[i % 4u];
    if plane == NO_PLANE {
        return 1.0;
    }
    return select(0.0, 1.0, load_0(vec2i(r.pixel), i32(plane)).x >= 1.0);
}
