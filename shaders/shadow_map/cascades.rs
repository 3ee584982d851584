//! Selection of a receiver's cascade, and the blending of two cascades.
//!
//! The first cascade that contains the receiver is used. The receiver and everything that the
//! kernel reaches must be inside its map, and the receiver must be before its far plane. The
//! distance from the camera is not used, so each map is used over its whole extent. The
//! visibilities of two cascades blend near the edge of a map, since a line would show there between
//! texels of two sizes.

use super::{
    coord::{clip_w, point_over_w, texel_from_point},
    layers::{MapLayer, ShadowMapUniforms},
};
use glam::{Mat4, Vec2, Vec3};
use umbrage_core::{Module, module};

/// Functions without images or uniforms. It needs the modules [`MATH`](umbrage_core::MATH),
/// [`LAYERS`](super::layers::LAYERS) and [`PROJECTION`](super::coord::PROJECTION).
pub const CASCADES: Module = module!("cascades");

/// WGSL functions that read the kernel's layers: `layer_at`, `map_layer`, `cascade_at`, `holds`,
/// `share_of_layer`.
pub(crate) const LAYER_PICK: Module = module!("layer_pick");

/// Returns the distance of `p` (world space) inside a cascade's map: to the nearest side of the
/// map, texels (x), and to the far plane, clip depth (y). Negative outside.
#[inline(always)]
pub fn room_around(clip_from_world: Mat4, p: Vec3, size: f32) -> Vec2 {
    let w = clip_w(&clip_from_world, p);
    let point = point_over_w(&clip_from_world, p, w);
    let texel = texel_from_point(point, size);
    let across = texel.x.min(size - texel.x);
    let down = texel.y.min(size - texel.y);
    Vec2::new(across.min(down), 1.0 - point.z)
}

/// Returns whether a cascade contains a receiver at this distance inside, for kernels that reach
/// `reach` texels.
#[inline(always)]
pub fn is_held(room: Vec2, reach: f32) -> bool {
    room.x > reach && room.y >= 0.0
}

/// Returns the weight, 0..=1, of a cascade's visibility for a receiver at this distance inside. The
/// remainder is the weight of the next cascade. The weight grows over `blend` texels (more than 0),
/// starting where the cascade begins to contain the receiver.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "`clamp` lets NaN through, and this must bound it as the shader does"
)]
pub fn own_share(room: Vec2, reach: f32, depth_in_texels: f32, blend: f32) -> f32 {
    let inside = (room.x - reach).min(room.y * depth_in_texels);
    (inside / blend).max(0.0).min(1.0)
}

/// Returns the index of the first cascade that contains a receiver at `p` (world space), or of the
/// last cascade if none does.
#[inline(always)]
pub fn cascade_at(m: &ShadowMapUniforms, p: Vec3) -> i32 {
    let last = m.used_layers().len() - 1;
    for (index, layer) in m.layers[..last].iter().enumerate() {
        if holds(m, layer, p) {
            return index as i32;
        }
    }
    last as i32
}

/// Returns whether a cascade contains a receiver at `p` (world space).
#[inline(always)]
pub fn holds(m: &ShadowMapUniforms, layer: &MapLayer, p: Vec3) -> bool {
    let room = room_around(layer.clip_from_world, p, m.size);
    is_held(room, m.pick_reach)
}

/// Returns the weight, 0..=1, of the layer `index`, which was selected for a receiver at `p` (world
/// space). The remainder is the weight of the next layer. It is 1 if the next layer doesn't contain
/// the receiver.
#[inline(always)]
pub fn share_of_layer(m: &ShadowMapUniforms, index: i32, p: Vec3) -> f32 {
    let used = m.used_layers();
    let layer = &used[index as usize];
    let Some(next) = used.get(index as usize + 1) else {
        return 1.0;
    };
    let room = room_around(layer.clip_from_world, p, m.size);
    let share = own_share(room, m.pick_reach, layer.depth_in_texels, m.blend);
    if share < 1.0 && holds(m, next, p) {
        share
    } else {
        1.0
    }
}

/// Returns the weighted mean of two visibilities; `share` is the weight of the first.
#[inline(always)]
pub fn blended(own: f32, next: f32, share: f32) -> f32 {
    own * share + next * (1.0 - share)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(CASCADES, room_around(clip_from_world: Mat4, p: Vec3, size: f32) -> Vec2, needs [umbrage_core::MATH, super::layers::LAYERS, super::coord::PROJECTION]),
    umbrage_core::twin!(CASCADES, own_share(room: Vec2, reach: f32, depth_in_texels: f32, blend: f32) -> f32, needs [umbrage_core::MATH, super::layers::LAYERS, super::coord::PROJECTION]),
    umbrage_core::twin!(CASCADES, blended(own: f32, next: f32, share: f32) -> f32, needs [umbrage_core::MATH, super::layers::LAYERS, super::coord::PROJECTION]),
];
