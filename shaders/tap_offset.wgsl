// Twin of `tap_offset` in soft_taps.rs. Its own module, since it reads neither image nor table.

fn tap_offset(axes: vec4f, q: vec2f, shift: vec2f) -> vec2f {
    let x = wrapped(q.x + shift.x);
    let y = wrapped(q.y + shift.y);
    return vec2f(axes.x * x + axes.z * y, axes.y * x + axes.w * y);
}
