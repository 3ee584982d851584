// Variant of `receive` for one layer per receiver.

fn receive(r: Receiver) -> f32 {
    // w is 0 or 1, so its sign bit is never set.
    opaque_zero = bitcast<u32>(kernel.lookup.light.w) >> 31u;
    return visibility_in(layer_at(kernel.lookup.light, r.position), r);
}
