// Twin of hard.rs: one texel decides.

fn receive(r: Receiver) -> f32 {
    let l = shadow_coord(kernel, r.position, r.normal);
    if !l.seen {
        return 1.0;
    }
    return tap(i32(kernel.size), l, i32(floor(l.texel.x)), i32(floor(l.texel.y)));
}
