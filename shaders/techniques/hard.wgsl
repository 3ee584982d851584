// Twin of hard.rs: one texel decides.

fn receive(r: Receiver) -> f32 {
    let l = shadow_coord(kernel.lookup, r.position, r.normal);
    if !l.seen {
        return 1.0;
    }
    return tap(i32(kernel.lookup.size), l, i32(floor(l.texel.x)), i32(floor(l.texel.y)));
}
