// Twin of sample_pattern.rs: rotation or shift of the pattern per pixel, tap positions on the map,
// and tap weights.

fn noise_index(x: u32, y: u32) -> u32 {
    let a = x * 288237660u + y * 25070368u;
    return (a * 52u + (a >> 16u) * 64417u) >> 26u;
}

fn turned(axes: vec4f, turn: vec2f) -> vec4f {
    return vec4f(
        axes.x * turn.x + axes.z * turn.y,
        axes.y * turn.x + axes.w * turn.y,
        axes.z * turn.x - axes.x * turn.y,
        axes.w * turn.x - axes.y * turn.y,
    );
}

fn wrapped(x: f32) -> f32 {
    return select(x, x - 2.0, x >= 1.0);
}

fn place(at: vec2f, axes: vec4f, q: vec2f) -> vec2f {
    return vec2f(at.x + axes.x * q.x + axes.z * q.y, at.y + axes.y * q.x + axes.w * q.y);
}

fn tap_place(at: vec2f, axes: vec4f, q: vec2f, shift: vec2f) -> vec2f {
    return place(at, axes, vec2f(wrapped(q.x + shift.x), wrapped(q.y + shift.y)));
}

fn from_middle(x: f32, y: f32, least: f32) -> f32 {
    return max(max(abs(x), abs(y)), least);
}

fn closer_by(m: f32) -> f32 {
    return m * m;
}

fn tap_weight(m: f32, nearer: f32) -> f32 {
    return m * m * (m * m) / (nearer * nearer);
}
