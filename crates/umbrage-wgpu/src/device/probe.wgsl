// Triangles in a row, 4 pixels apart. The right edge of each begins slightly further right of the
// grid than the one before it, and ends on the grid. The row in which it crosses its column of
// pixel centres therefore shows the snapped position of its upper end. Positions are pixels; all
// numbers here are exact.

const STRIP: f32 = 4.0;
const ROWS: f32 = 512.0;
const WIDTH: f32 = 256.0;

@vertex
fn place(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    let strip = f32(i / 3u);
    let column = STRIP * strip + 3.5;
    let beyond_grid = (strip + 0.5) / 512.0;
    var p = vec3f(column - 0.25 + beyond_grid, 0.0, 0.25);
    if i % 3u == 1u {
        p = vec3f(column + 0.125, ROWS, 0.25);
    }
    if i % 3u == 2u {
        p = vec3f(column - 3.0, 0.0, 0.75);
    }
    return vec4f(p.x * (2.0 / WIDTH) - 1.0, 1.0 - p.y * (2.0 / ROWS), p.z, 1.0);
}

@fragment
fn depth(@builtin(position) at: vec4f) -> @location(0) f32 {
    return at.z;
}
