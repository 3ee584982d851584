// Twin of hard.rs: comparison with one texel.

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    return tap(size_0().x, l, i32(floor(l.texel.x)), i32(floor(l.texel.y)));
}
