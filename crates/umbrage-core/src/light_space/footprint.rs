//! Resolution where it counts: how many of a map's texels fall on a pixel, and what side a map
//! needs.
//!
//! A pixel's step right or down moves the seen point along its plane by dp/dx or dp/dy (Igehy 1999,
//! "Tracing ray differentials"); the map's projection turns these into texels, the columns of a 2 x
//! 2 matrix J. Its least singular value is the number of texels in a pixel in the direction in
//! which there are the fewest: 1 or more where no texel is larger than a pixel, whichever way it is
//! stretched. J grows with the map's side N, so the side at which it reaches 1 is N / least
//! singular value.

use crate::{
    gbuffer::receivers::Receivers,
    light_space::layers::{LayerPicker, LightSpaces},
    math::{cross3, dot3, transform},
    parallel::prelude::*,
    scene::camera::{CameraRays, MAX_SIDE},
    view::View,
};
use glam::{Mat4, Vec2, Vec3};

/// Returns, for each receiver that faces the light, shadowed or not, and falls on a map: how many
/// texels of it a pixel spans in the direction in which it spans the fewest. In the order of the
/// pixels. `size` is the maps' side in texels; `receivers` are what the view's camera sees.
pub fn texels_per_pixel(
    view: &View<'_>,
    receivers: &Receivers,
    spaces: &LightSpaces,
    size: u32,
) -> Vec<f32> {
    let picker = LayerPicker::new(spaces, size);
    texels_per_pixel_in(view, receivers, size, |position, _| {
        let layer = picker.layer_at(position)?;
        Some(picker.clip_from_world(layer))
    })
}

/// As [`texels_per_pixel`], where a receiver at a position (world space) with a normal is looked up
/// in the map that `clip_from_world` returns; in none, if it returns none.
pub fn texels_per_pixel_in(
    view: &View<'_>,
    receivers: &Receivers,
    size: u32,
    clip_from_world: impl Fn(Vec3, Vec3) -> Option<Mat4> + Sync,
) -> Vec<f32> {
    let rays = view.camera.rays();
    let width = receivers.size.x.max(1) as usize;
    let of_receiver = |i: usize| {
        let position = receivers.position(i);
        let normal = receivers.normal(i);
        let faces_away = dot3(normal, view.light.direction_from(position)) <= 0.0;
        if !receivers.receives[i] || faces_away {
            return None;
        }
        let clip_from_world = clip_from_world(position, normal)?;
        let pixel = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let steps = PixelSteps::new(&rays, pixel, position, normal);
        fewest_texels(&steps, clip_from_world, position, size as f32)
    };
    (0..receivers.len())
        .into_par_iter()
        .filter_map(of_receiver)
        .collect()
}

/// Returns the least side, texels, of a map that lies in `spaces` at which, for a share `quantile`
/// (0..=1) of the seen receivers that face the light, no texel is larger than a pixel; at most
/// [`MAX_SIDE`]. Margins that kernels take from the map are neglected. None if no such receiver is
/// seen.
pub fn side_for(
    view: &View<'_>,
    receivers: &Receivers,
    spaces: &LightSpaces,
    quantile: f32,
) -> Option<u32> {
    let mut texels = texels_per_pixel(view, receivers, spaces, 1);
    texels.par_sort_unstable_by(f32::total_cmp);
    side_of(&texels, quantile)
}

/// As [`side_for`], from the numbers of texels per pixel on a map of one texel, in rising order.
pub fn side_of(texels: &[f32], quantile: f32) -> Option<u32> {
    // Casts saturate: where a texel never gets as small, the greatest side is the answer.
    at_least(texels, quantile).map(|texels| ((1.0 / texels).ceil() as u32).clamp(1, MAX_SIDE))
}

/// Returns, of numbers in rising order, the one that a share `quantile` (0..=1) of them reaches;
/// none of no numbers.
pub fn at_least(rising: &[f32], quantile: f32) -> Option<f32> {
    let last = rising.len().checked_sub(1)?;
    Some(rising[((1.0 - quantile.clamp(0.0, 1.0)) * last as f32).floor() as usize])
}

/// How far the seen point moves on its plane, metres, when the pixel's ray moves by a pixel: dp/dx
/// and dp/dy.
struct PixelSteps {
    right: Vec3,
    down: Vec3,
}

impl PixelSteps {
    /// The ray through `pixel` meets, at position `p`, the plane with the normal `n`.
    fn new(rays: &CameraRays, pixel: Vec2, p: Vec3, n: Vec3) -> Self {
        let origin = (rays.origin + rays.origin_dx * pixel.x + rays.origin_dy * pixel.y).truncate();
        let direction = (rays.dir + rays.dir_dx * pixel.x + rays.dir_dy * pixel.y).truncate();
        let t = dot3(p - origin, direction) / dot3(direction, direction);
        // How far the point at the same t moves.
        let right = rays.origin_dx.truncate() + rays.dir_dx.truncate() * t;
        let down = rays.origin_dy.truncate() + rays.dir_dy.truncate() * t;
        Self {
            right: moved_to_plane(right, direction, n),
            down: moved_to_plane(down, direction, n),
        }
    }
}

/// Returns a step that leaves a plane with the normal `n`, changed along `direction` so that it
/// stays on the plane.
fn moved_to_plane(step: Vec3, direction: Vec3, n: Vec3) -> Vec3 {
    step - direction * (dot3(n, step) / dot3(n, direction))
}

/// Returns the least singular value of the 2 x 2 matrix whose columns are the texels that two steps
/// span at `p`, on a map of `size` texels; none if the point is not on the map.
fn fewest_texels(steps: &PixelSteps, clip_from_world: Mat4, p: Vec3, size: f32) -> Option<f32> {
    let clip = transform(clip_from_world, p);
    let ndc = Vec2::new(clip.x / clip.w, clip.y / clip.w);
    let is_on_map = clip.w > 0.0 && ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0;
    if !is_on_map {
        return None;
    }
    let clip_right = clip_from_world * steps.right.extend(0.0);
    let clip_down = clip_from_world * steps.down.extend(0.0);
    // By the quotient rule, d(x / w) = (dx - (x / w) dw) / w; the map's side spans two units.
    let texels_per_unit = 0.5 * size / clip.w;
    let right = Vec2::new(
        clip_right.x - ndc.x * clip_right.w,
        clip_right.y - ndc.y * clip_right.w,
    ) * texels_per_unit;
    let down = Vec2::new(
        clip_down.x - ndc.x * clip_down.w,
        clip_down.y - ndc.y * clip_down.w,
    ) * texels_per_unit;
    let sum_of_squares = right.length_squared() + down.length_squared();
    let area = cross3(right.extend(0.0), down.extend(0.0)).z.abs();
    // The product of both singular values is the area, the sum of their squares that of the
    // entries.
    let root = (sum_of_squares * sum_of_squares - 4.0 * area * area)
        .max(0.0)
        .sqrt();
    let greatest = (0.5 * (sum_of_squares + root)).sqrt();
    let least = area / greatest;
    least.is_finite().then_some(least)
}
