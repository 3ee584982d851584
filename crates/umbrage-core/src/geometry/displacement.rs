//! Displacement mapping (Cook 1984, "Shade trees"): a vertex moves along its unit normal by
//! `lambda (2 h - 1)`, where h is a texture's first channel at its uv, bilinear and repeating.
//!
//! [`Geometry::bake`](crate::Geometry::bake) displaces meshes whose material has a displacement. It
//! first splits each triangle in four, as often as the material requires, since a coarse mesh
//! cannot show relief. Then it moves the vertices. Both backends, truth, the depth pass and the
//! camera pass draw the resulting list, so they show the same relief.
//!
//! * **Seams.** At a texture seam, several vertices share a position and read different heights.
//!   They are moved together, by the mean of their offsets, so the surface never tears.
//! * **Shading normals** are averaged from the moved triangles, so that they fit any relief and any
//!   lambda without the derivatives of the texture. Sharp edges stay sharp. With a normal map the
//!   old normals are kept: a map that fits the relief already contains its slopes, and both
//!   together would tilt twice.
//! * **Known failures.** Relief finer than the triangles is aliased. Vertices of a hollow may cross
//!   if |lambda| exceeds its radius of curvature. An open mesh shows its rim.
//!
//! A program that displaces in its own vertex shader can use [`DISPLACEMENT`], which is bit-equal
//! to the Rust half:
//!
//! ```
//! use umbrage_core::{displacement::DISPLACEMENT, join, Module};
//!
//! let vertex_shader = Module { name: "relief", text: r#"
//!     @group(0) @binding(0) var heights: texture_2d<f32>;
//!
//!     fn height(texel: vec2u) -> f32 { return textureLoad(heights, texel, 0).x; }
//!
//!     fn moved(position: vec3f, normal: vec3f, uv: vec2f, lambda: f32) -> vec3f {
//!         let size = textureDimensions(heights);
//!         let a = bilinear_first(uv, size);
//!         let b = bilinear_second(a, size);
//!         let h = bilinear_blend(
//!             height(a),
//!             height(vec2u(b.x, a.y)),
//!             height(vec2u(a.x, b.y)),
//!             height(b),
//!             bilinear_weights(uv, size),
//!         );
//!         return displaced(position, normal, h, lambda);
//!     }
//! "# };
//! let wgsl = join(&[DISPLACEMENT, vertex_shader]);
//! assert!(wgsl.contains("fn displaced("));
//! ```

use crate::{recipe::shader::Module, scene::material::Texture};
use glam::{UVec2, Vec2, Vec3};

/// The WGSL half; it needs no other module.
pub const DISPLACEMENT: Module = crate::module!("displacement");

/// Returns the fractional part of a repeating texture coordinate: 0 to below 1.
#[inline(always)]
pub fn repeated(t: f32) -> f32 {
    let part = t - t.floor();
    // The fraction of a tiny negative number rounds to 1.
    if part >= 1.0 { 0.0 } else { part }
}

/// Returns the distance of a texture coordinate from the centre of the first of `n` texels, along
/// one axis, in texels: -0.5 to below n - 0.5.
#[inline(always)]
pub fn from_first_centre(t: f32, n: u32) -> f32 {
    repeated(t) * n as f32 - 0.5
}

/// Returns a texel's index among `n`; the one before the first is the last.
#[inline(always)]
fn wrap_texel(t: f32, n: u32) -> u32 {
    if t < 0.0 { n.wrapping_sub(1) } else { t as u32 }
}

/// Returns the texel above and to the left of `uv`, repeating.
#[inline(always)]
pub fn bilinear_first(uv: Vec2, size: UVec2) -> UVec2 {
    let x = from_first_centre(uv.x, size.x).floor();
    let y = from_first_centre(uv.y, size.y).floor();
    UVec2::new(wrap_texel(x, size.x), wrap_texel(y, size.y))
}

/// Returns the texel below and to the right of `first`, repeating.
#[inline(always)]
pub fn bilinear_second(first: UVec2, size: UVec2) -> UVec2 {
    let next = UVec2::new(first.x.wrapping_add(1), first.y.wrapping_add(1));
    UVec2::new(
        if next.x >= size.x { 0 } else { next.x },
        if next.y >= size.y { 0 } else { next.y },
    )
}

/// Returns the position of `uv` between the first texel's centre and the second's, each 0 to 1.
#[inline(always)]
pub fn bilinear_weights(uv: Vec2, size: UVec2) -> Vec2 {
    let x = from_first_centre(uv.x, size.x);
    let y = from_first_centre(uv.y, size.y);
    Vec2::new(x - x.floor(), y - y.floor())
}

/// Blends along x, then along y.
#[inline(always)]
pub fn bilinear_blend(
    top_left: f32,
    top_right: f32,
    bottom_left: f32,
    bottom_right: f32,
    weights: Vec2,
) -> f32 {
    let top = top_left + (top_right - top_left) * weights.x;
    let bottom = bottom_left + (bottom_right - bottom_left) * weights.x;
    top + (bottom - top) * weights.y
}

/// Returns a vertex moved along its unit normal by `lambda (2 h - 1)` metres.
#[inline(always)]
pub fn displaced(position: Vec3, normal: Vec3, h: f32, lambda: f32) -> Vec3 {
    let metres = lambda * (2.0 * h - 1.0);
    Vec3::new(
        position.x + normal.x * metres,
        position.y + normal.y * metres,
        position.z + normal.z * metres,
    )
}

/// Returns the first channel of a valid texture at `uv` (origin top left), bilinear and repeating.
pub fn height(texture: &Texture, uv: Vec2) -> f32 {
    let first = bilinear_first(uv, texture.size);
    let second = bilinear_second(first, texture.size);
    let top_left = first_channel(texture, first.x, first.y);
    let top_right = first_channel(texture, second.x, first.y);
    let bottom_left = first_channel(texture, first.x, second.y);
    let bottom_right = first_channel(texture, second.x, second.y);
    let weights = bilinear_weights(uv, texture.size);
    bilinear_blend(top_left, top_right, bottom_left, bottom_right, weights)
}

fn first_channel(texture: &Texture, x: u32, y: u32) -> f32 {
    let index = u64::from(y) * u64::from(texture.size.x) + u64::from(x);
    texture.texels.get(index as usize)[0]
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(DISPLACEMENT, repeated(t: f32) -> f32),
    crate::twin!(DISPLACEMENT, from_first_centre(t: f32, n: u32) -> f32),
    crate::twin!(DISPLACEMENT, bilinear_first(uv: Vec2, size: UVec2) -> UVec2),
    crate::twin!(DISPLACEMENT, bilinear_second(first: UVec2, size: UVec2) -> UVec2),
    crate::twin!(DISPLACEMENT, bilinear_weights(uv: Vec2, size: UVec2) -> Vec2),
    crate::twin!(DISPLACEMENT, bilinear_blend(a: f32, b: f32, c: f32, d: f32, weights: Vec2) -> f32),
    crate::twin!(DISPLACEMENT, displaced(position: Vec3, normal: Vec3, h: f32, lambda: f32) -> Vec3),
];

#[cfg(test)]
#[path = "displacement_tests.rs"]
mod tests;
