// Twin of `depth_on_plane` in texel_compare.rs. Separate from texel_compare.wgsl, since the twin
// tests use it without an image.

fn depth_on_plane(depth: f32, gradient: vec2f, deepest: f32, from_texel: vec2f, x: i32, y: i32) -> f32 {
    let right = gradient.x * (f32(x) + 0.5 - from_texel.x);
    let down = gradient.y * (f32(y) + 0.5 - from_texel.y);
    return min(depth + right + down, deepest);
}
