// Twin of `tap_place` in soft_taps.rs. Its own module, since it reads neither image nor table.

fn tap_place(at: vec2f, axes: vec4f, q: vec2f, shift: vec2f) -> vec2f {
    let x = wrapped(q.x + shift.x);
    let y = wrapped(q.y + shift.y);
    return vec2f(at.x + axes.x * x + axes.z * y, at.y + axes.y * x + axes.w * y);
}
