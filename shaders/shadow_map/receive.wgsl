// Common part of every map technique's kernel: it projects the receiver to a layer and calls the
// technique's `visibility`, or `full_light` outside the map.

// Returns the visibility in one layer.
fn visibility_in(layer: i32, r: Receiver) -> f32 {
    let l = shadow_coord_in(layer, kernel.lookup, r.position, r.normal);
    if !l.covered {
        return full_light(r);
    }
    return visibility(l, r);
}
