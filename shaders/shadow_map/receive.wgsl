// What every map technique's kernel does: it picks a layer, finds the receiver's place there, and asks the technique. `visibility` is
// the technique's, and `full_light` its own or the choice's. `receive` is the map's choice between the variants below.

// The answer of one layer.
fn visibility_in(layer: i32, r: Receiver) -> f32 {
    let l = shadow_coord_in(layer, kernel.lookup, r.position, r.normal);
    if !l.seen {
        return full_light(r);
    }
    return visibility(l, r);
}

// Where each receiver has one layer.
fn receive_from_one(r: Receiver) -> f32 {
    // w is 0 or 1: its sign is never set.
    opaque_zero = bitcast<u32>(kernel.lookup.light.w) >> 31u;
    return visibility_in(layer_at(kernel.lookup.light, r.position), r);
}
