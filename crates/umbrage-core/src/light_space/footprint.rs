//! Effective resolution: the number of a map's texels per pixel, and the map side that a view
//! needs.
//!
//! A pixel's step right or down moves the visible point along its plane by dp/dx or dp/dy (Igehy
//! 1999, "Tracing ray differentials"). The map's projection turns these into texels, the columns of
//! a 2 x 2 matrix J. Its least singular value is the number of texels per pixel in the direction
//! with the fewest texels. It is 1 or more where no texel is larger than a pixel, in any direction.
//! J is proportional to the map's side N, so it reaches 1 at the side N / least singular value.

use crate::{
    gbuffer::receivers::Receivers,
    light_space::layers::{LayerPicker, LightSpaces},
    math::{cross3, dot3, transform},
    parallel::prelude::*,
    scene::camera::{CameraRays, MAX_SIDE},
    view::View,
};
use glam::{Mat4, Vec2, Vec3};

/// Returns, for each receiver that faces the light and is on a map, shadowed or not, the number of
/// texels per pixel in the direction with the fewest. In the order of the pixels. `size` is the
/// side of the maps in texels; `receivers` are those of the view's camera.
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

/// Returns [`texels_per_pixel`] with a custom choice of the map: `clip_from_world` returns the map
/// for a receiver's position (world space) and normal, or `None` to skip it.
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

/// Returns the least side, texels, of a map in `spaces` at which no texel is larger than a pixel.
/// This holds for a share `quantile` (0..=1) of the visible receivers that face the light. At most
/// [`MAX_SIDE`]. Kernel margins are neglected. `None` if no such receiver is visible.
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

/// Returns [`side_for`] from the numbers of texels per pixel on a map of one texel, in rising
/// order.
pub fn side_of(texels: &[f32], quantile: f32) -> Option<u32> {
    // Casts saturate: if no side makes texels small enough, return the greatest side.
    at_least(texels, quantile).map(|texels| ((1.0 / texels).ceil() as u32).clamp(1, MAX_SIDE))
}

/// Returns the number, of a rising list, that a share `quantile` (0..=1) of the list reaches or
/// exceeds. `None` for an empty list.
pub fn at_least(rising: &[f32], quantile: f32) -> Option<f32> {
    let last = rising.len().checked_sub(1)?;
    Some(rising[((1.0 - quantile.clamp(0.0, 1.0)) * last as f32).floor() as usize])
}

/// Displacements of the visible point on its plane, metres, when the pixel's ray moves by a pixel:
/// dp/dx and dp/dy.
struct PixelSteps {
    right: Vec3,
    down: Vec3,
}

impl PixelSteps {
    /// Computes the steps for the ray through `pixel`, which meets the plane with the normal `n` at
    /// position `p`.
    fn new(rays: &CameraRays, pixel: Vec2, p: Vec3, n: Vec3) -> Self {
        let origin = (rays.origin + rays.origin_dx * pixel.x + rays.origin_dy * pixel.y).truncate();
        let direction = (rays.dir + rays.dir_dx * pixel.x + rays.dir_dy * pixel.y).truncate();
        let t = dot3(p - origin, direction) / dot3(direction, direction);
        // Displacement of the point at the same t.
        let right = rays.origin_dx.truncate() + rays.dir_dx.truncate() * t;
        let down = rays.origin_dy.truncate() + rays.dir_dy.truncate() * t;
        Self {
            right: moved_to_plane(right, direction, n),
            down: moved_to_plane(down, direction, n),
        }
    }
}

/// Projects a step along `direction` onto the plane with the normal `n`.
fn moved_to_plane(step: Vec3, direction: Vec3, n: Vec3) -> Vec3 {
    step - direction * (dot3(n, step) / dot3(n, direction))
}

/// Returns the least singular value of the 2 x 2 matrix whose columns are the texels that two steps
/// span at `p`, on a map of `size` texels. `None` if the point is not on the map.
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
    // The product of both singular values is the area; the sum of their squares is that of the
    // entries.
    let root = (sum_of_squares * sum_of_squares - 4.0 * area * area)
        .max(0.0)
        .sqrt();
    let greatest = (0.5 * (sum_of_squares + root)).sqrt();
    let least = area / greatest;
    least.is_finite().then_some(least)
}
