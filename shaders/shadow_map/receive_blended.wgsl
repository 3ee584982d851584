// Variant of `receive` that blends a cascade with the next one near the edge of its map. Twin of
// `blend_layers` in batch.rs.

fn receive(r: Receiver) -> f32 {
    // See receive_one.wgsl.
    opaque_zero = bitcast<u32>(kernel.lookup.light.w) >> 31u;
    let layer = layer_at(kernel.lookup.light, r.position);
    let own = visibility_in(layer, r);
    let share = share_of_layer(layer, r.position);
    if share >= 1.0 {
        return own;
    }
    return blended(own, visibility_in(layer + 1, r), share);
}
