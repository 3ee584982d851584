// Vertex shader of one triangle per instance. Each triangle covers the target.

struct UmbragePixel {
    @builtin(position) at: vec4f,
    @location(0) @interpolate(flat) instance: u32,
}

@vertex fn umbrage_fullscreen(@builtin(vertex_index) i: u32, @builtin(instance_index) instance: u32) -> UmbragePixel {
    return UmbragePixel(vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0), instance);
}
