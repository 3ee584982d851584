//! Resolution where it counts: how many of a map's texels fall on a pixel, and what side a map needs.
//!
//! A pixel's step right or down moves the seen point along its plane by dp/dx or dp/dy (Igehy 1999, "Tracing ray
//! differentials"); the map's projection turns these into texels, the columns of a 2 x 2 matrix J. Its least singular value
//! is the number of texels in a pixel in the direction in which there are the fewest: 1 or more where no texel is larger
//! than a pixel, whichever way it is stretched. J grows with the map's side N, so the side at which it reaches 1 is
//! N / least singular value.

use crate::{
    CameraRays, LightSpace, LightSpaces, MAX_SIDE, Receivers, View,
    math::{cross3, dot3, transform},
};
use glam::{Mat4, Vec2, Vec3};

/// Of each receiver that faces the light, shadowed or not, and falls on a map: how many texels of it a pixel spans in the direction in which
/// it spans the fewest. `size` is the maps' side in texels; `receivers` are what the view's camera sees. In the order of
/// the pixels.
pub fn texels_per_pixel(
    view: &View<'_>,
    receivers: &Receivers,
    spaces: &LightSpaces,
    size: u32,
) -> Vec<f32> {
    let rays = view.camera.rays();
    let width = receivers.size.x.max(1) as usize;
    let of = |i: usize| {
        let (p, n) = (receivers.position(i), receivers.normal(i));
        if !receivers.receives[i] || dot3(n, view.light.direction_from(p)) <= 0.0 {
            return None;
        }
        let pixel = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let space = spaces
            .spaces
            .iter()
            .max_by(|a, b| ahead(a, p).total_cmp(&ahead(b, p)))?;
        fewest(
            &steps(&rays, pixel, p, n),
            space.clip_from_world(),
            p,
            size as f32,
        )
    };
    (0..receivers.len()).filter_map(of).collect()
}

/// The least side, texels, of a map that lies in `spaces` at which, for a share `quantile` (0..=1) of the seen receivers
/// that face the light, no texel is larger than a pixel. Margins that kernels take from the map are neglected. None if
/// no such receiver is seen; at most [`MAX_SIDE`].
pub fn side_for(
    view: &View<'_>,
    receivers: &Receivers,
    spaces: &LightSpaces,
    quantile: f32,
) -> Option<u32> {
    let mut texels = texels_per_pixel(view, receivers, spaces, 1);
    texels.sort_unstable_by(f32::total_cmp);
    side_of(&texels, quantile)
}

/// As [`side_for`], of the rising numbers of texels per pixel on a map of one texel.
pub fn side_of(texels: &[f32], quantile: f32) -> Option<u32> {
    // Casts saturate: where a texel never gets as small, the greatest side is the answer.
    at_least(texels, quantile).map(|texels| ((1.0 / texels).ceil() as u32).clamp(1, MAX_SIDE))
}

/// Of rising numbers, that which a share `quantile` (0..=1) of them reaches; none of no numbers.
pub fn at_least(rising: &[f32], quantile: f32) -> Option<f32> {
    let last = rising.len().checked_sub(1)?;
    Some(rising[((1.0 - quantile.clamp(0.0, 1.0)) * last as f32).floor() as usize])
}

/// Distance along the view of a space: of a cube's faces, the one in which a point lies has the greatest.
fn ahead(space: &LightSpace, p: Vec3) -> f32 {
    -transform(space.view_from_world, p).z
}

/// Where the seen point goes, on its plane, when the ray goes a pixel right and a pixel down.
fn steps(rays: &CameraRays, pixel: Vec2, p: Vec3, n: Vec3) -> [Vec3; 2] {
    let at = |c: glam::Vec4, dx: glam::Vec4, dy: glam::Vec4| {
        (c + dx * pixel.x + dy * pixel.y).truncate()
    };
    let origin = at(rays.origin, rays.origin_dx, rays.origin_dy);
    let direction = at(rays.dir, rays.dir_dx, rays.dir_dy);
    let t = dot3(p - origin, direction) / dot3(direction, direction);
    let step = |origin: glam::Vec4, dir: glam::Vec4| {
        let moved = origin.truncate() + dir.truncate() * t;
        moved - direction * (dot3(n, moved) / dot3(n, direction))
    };
    [
        step(rays.origin_dx, rays.dir_dx),
        step(rays.origin_dy, rays.dir_dy),
    ]
}

/// The least singular value of the texels that two steps span; none if the point is not on the map.
fn fewest([right, down]: &[Vec3; 2], clip_from_world: Mat4, p: Vec3, size: f32) -> Option<f32> {
    let clip = transform(clip_from_world, p);
    let (x, y) = (clip.x / clip.w, clip.y / clip.w);
    if !(clip.w > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0) {
        return None;
    }
    let texels = |v: Vec3| {
        let c = clip_from_world * v.extend(0.0);
        Vec2::new(c.x - x * c.w, c.y - y * c.w) * (0.5 * size / clip.w)
    };
    let (a, b) = (texels(*right), texels(*down));
    let (squares, area) = (
        a.length_squared() + b.length_squared(),
        cross3(a.extend(0.0), b.extend(0.0)).z.abs(),
    );
    // The product of both singular values is the area, the sum of their squares that of the entries.
    let greatest =
        (0.5 * (squares + (squares * squares - 4.0 * area * area).max(0.0).sqrt())).sqrt();
    let least = area / greatest;
    least.is_finite().then_some(least)
}
