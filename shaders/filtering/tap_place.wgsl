// Twin of `place` and `tap_place` in pattern_taps.rs. Its own module, since it reads neither image nor table.

fn place(at: vec2f, axes: vec4f, q: vec2f) -> vec2f {
    return vec2f(at.x + axes.x * q.x + axes.z * q.y, at.y + axes.y * q.x + axes.w * q.y);
}

fn tap_place(at: vec2f, axes: vec4f, q: vec2f, shift: vec2f) -> vec2f {
    return place(at, axes, vec2f(wrapped(q.x + shift.x), wrapped(q.y + shift.y)));
}
