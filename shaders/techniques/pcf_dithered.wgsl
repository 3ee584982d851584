// Twin of pcf_dithered.rs: four taps, two texels apart, shifted by the pixel's parity.

fn visibility(l: ShadowCoord, r: Receiver) -> f32 {
    let size = size_0().x;
    let ox = f32(r.pixel.x & 1u);
    let oy = f32((r.pixel.x ^ r.pixel.y) & 1u);
    let left = i32(floor(l.texel.x + (ox - 1.5)));
    let right = i32(floor(l.texel.x + (ox + 0.5)));
    let top = i32(floor(l.texel.y + (oy - 1.5)));
    let bottom = i32(floor(l.texel.y + (oy + 0.5)));
    let lit = tap(size, l, left, top) + tap(size, l, right, top) + tap(size, l, left, bottom) + tap(size, l, right, bottom);
    return lit * 0.25;
}
