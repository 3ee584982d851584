// One triangle over the whole viewport, at a depth of 1/4.

@vertex
fn place(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    let x = select(-1.0, 3.0, i == 1u);
    let y = select(-1.0, 3.0, i == 2u);
    return vec4f(x, y, 0.25, 1.0);
}
