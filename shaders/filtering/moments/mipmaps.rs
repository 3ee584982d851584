//! Level selection in a mipmapped moment map: the level whose texels are as large as a pixel's
//! footprint on the map.
//!
//! Williams 1983, "Pyramidal parametrics", applied to moment maps: means of moments can be averaged
//! further. A pixel's footprint follows from the camera's uniforms and the receiver's plane. Levels
//! are selected with comparisons and products only, without logarithms.

use glam::{Vec2, Vec3, Vec4};
use umbrage_core::{Camera, Invalid, Module, math::dot3, module, uniforms};

/// The WGSL half.
pub(crate) const MIPMAPS: Module = module!("mipmaps");

/// Maximum number of levels of a moment map beyond its first. Texels of the last one are means of
/// 64 x 64, and sums of 64 squares of the steepest exponential are still finite.
pub const MAX_MIPMAPS: u32 = 6;

/// Least side of a level, texels, as a power of two. A lookup in the last level reaches little more
/// than a tenth of the map.
const LEAST_SIDE_LOG2: u32 = 4;

/// Checks a number of levels.
///
/// # Errors
/// Errors if it is more than [`MAX_MIPMAPS`].
pub(crate) fn check_count(mipmaps: u32) -> Result<(), Invalid> {
    if mipmaps <= MAX_MIPMAPS {
        return Ok(());
    }
    let why = format!("are {mipmaps}");
    Err(Invalid::new(
        "mipmaps",
        why,
        format!("use 0 to {MAX_MIPMAPS}"),
    ))
}

/// Returns the number of levels beyond the first of a map of this side, at most `mipmaps`.
pub(crate) fn levels(mipmaps: u32, size: u32) -> u32 {
    let halvings = size.checked_ilog2().unwrap_or(0);
    let most = halvings.saturating_sub(LEAST_SIDE_LOG2);
    mipmaps.min(most).min(MAX_MIPMAPS)
}

/// Returns the side of a level of a map of this side, texels.
#[inline(always)]
pub(crate) fn level_side(size: u32, level: u32) -> u32 {
    size >> level
}

/// Returns the first row, texels, of a level from 1 on in the image that holds them one below the
/// other.
#[inline(always)]
pub(crate) fn level_start(size: u32, level: u32) -> u32 {
    (1..level).map(|finer| level_side(size, finer)).sum()
}

/// Returns the reach of a lookup in a level beyond the receiver's own texel, texels of the map. It
/// ends with the next texel of the level.
pub(crate) fn level_reach(level: u32) -> f32 {
    let side = (1_u32 << level) as f32;
    (1.5 * side - 1.0).max(1.0)
}

uniforms! {
    /// Data for the selection of a level. All zeros for maps without mipmaps.
    pub struct MipmapUniforms {
        /// Number of levels beyond the first.
        pub levels: u32,
        /// Eye position (w = 1), or the unit direction to the eye without perspective (w = 0),
        /// world space.
        pub eye: Vec4,
        /// xyz: unit direction from the scene towards the image, perpendicular to it. w: side of a
        /// pixel, metres, at a depth of one metre; at any depth without perspective.
        pub axis: Vec4,
    }
}

impl MipmapUniforms {
    /// Returns the uniforms of a map with this number of levels beyond its first.
    pub(crate) fn new(levels: u32, camera: &Camera) -> Self {
        if levels == 0 {
            return Self {
                levels: 0,
                eye: Vec4::ZERO,
                axis: Vec4::ZERO,
            };
        }
        let camera = camera.standard();
        let backwards = Vec3::from(camera.world_from_view.matrix3.z_axis).normalize_or_zero();
        let rays = camera.rays();
        // Rays start at one point with perspective, and otherwise have one direction.
        let right = (rays.origin_dx + rays.dir_dx).truncate();
        let down = (rays.origin_dy + rays.dir_dy).truncate();
        let pixel = right.cross(down).length().sqrt();
        let is_orthographic = camera.clip_from_view.row(3) == Vec4::W;
        let eye = if is_orthographic {
            backwards.extend(0.0)
        } else {
            camera.eye().extend(1.0)
        };
        Self {
            levels,
            eye,
            axis: backwards.extend(pixel),
        }
    }
}

/// Returns the side, texels, of a square with the area of a pixel's footprint on the map.
///
/// A pixel spans the same area on all planes at its depth that are parallel to the image. A surface
/// slanted to the ray has that area over the cosine of the slant, relative to the ray and not to
/// the image's axis. Multiplying by n.l projects this area to the light.
#[inline(always)]
pub(crate) fn texels_spanned(
    eye: Vec4,
    axis: Vec4,
    p: Vec3,
    n: Vec3,
    n_dot_l: f32,
    texel: f32,
) -> f32 {
    let to_eye = Vec3::new(
        eye.x - p.x * eye.w,
        eye.y - p.y * eye.w,
        eye.z - p.z * eye.w,
    );
    let depth = dot3(axis.truncate(), to_eye);
    let side = depth * axis.w;
    let across_rays = side * side * depth;
    let area = across_rays * n_dot_l.abs() / dot3(n, to_eye).abs();
    area.sqrt() / texel
}

/// Returns the finer of the two levels around a receiver (x) and the weight of the coarser one (y),
/// 0..1. Weights rise linearly between powers of two.
#[inline(always)]
pub(crate) fn mipmap_level(footprint: f32, levels: u32) -> Vec2 {
    let mut level = 0.0;
    let mut side = 1.0;
    for i in 0..MAX_MIPMAPS {
        if i < levels && footprint >= 2.0 * side {
            level += 1.0;
            side *= 2.0;
        }
    }
    // This is also false for NaN.
    if footprint > side && level < levels as f32 {
        return Vec2::new(level, footprint / side - 1.0);
    }
    Vec2::new(level, 0.0)
}

/// Returns the increase of the variance of the averaged positions over the first level, texels².
///
/// The variance of positions within a texel of s grows by (s² - 1) / 12. That of the blend of two
/// texels grows by up to (s² - 1) / 4. The next level's grows by four times as much.
#[inline(always)]
pub(crate) fn added_variance(level: Vec2) -> f32 {
    let side = (1_u32 << level.x as u32) as f32;
    (side * side * (1.0 + 3.0 * level.y) - 1.0) * 0.333_333_34
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(MIPMAPS, texels_spanned(eye: Vec4, axis: Vec4, p: Vec3, n: Vec3, n_dot_l: f32, texel: f32) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(MIPMAPS, mipmap_level(footprint: f32, levels: u32) -> Vec2, needs [umbrage_core::MATH]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;
    use umbrage_core::Extents;

    fn cameras() -> [Camera; 2] {
        let eye = Vec3::new(3.0, 4.0, 7.0);
        let target = Vec3::new(0.5, 0.0, -0.5);
        let size = UVec2::new(64, 40);
        let extents = Extents {
            left: -3.0,
            right: 3.0,
            bottom: -2.0,
            top: 2.0,
            near: 0.1,
            far: 50.0,
        };
        let perspective = Camera::perspective(eye, target, Vec3::Y, 0.9, [0.1, 100.0], size);
        let orthographic = Camera::orthographic(eye, target, Vec3::Y, extents, size);
        [perspective.expect("valid"), orthographic.expect("valid")]
    }

    /// Returns the intersection of the ray through a point of the image with a plane.
    fn on_plane(camera: &Camera, x: f32, y: f32, origin: Vec3, normal: Vec3) -> Vec3 {
        let rays = camera.rays();
        let start = (rays.origin + rays.origin_dx * x + rays.origin_dy * y).truncate();
        let direction = (rays.dir + rays.dir_dx * x + rays.dir_dy * y).truncate();
        start + direction * ((origin - start).dot(normal) / direction.dot(normal))
    }

    /// A pixel's footprint is the area that its corners' rays cut from the receiver's plane, as
    /// projected to the light.
    #[test]
    fn a_footprint_is_the_area_between_a_pixels_corners() {
        let texel = 0.01;
        let to_light = Vec3::new(0.3, 0.9, -0.2).normalize();
        let mut compared = 0;
        for camera in cameras() {
            for normal in [Vec3::Y, Vec3::new(0.4, 0.5, 0.8).normalize()] {
                for (x, y) in [(3.5, 30.5), (31.5, 20.5), (60.5, 37.5)] {
                    let at = |x, y| on_plane(&camera, x, y, Vec3::ZERO, normal);
                    let middle = at(x, y);
                    let right = at(x + 0.5, y) - at(x - 0.5, y);
                    let down = at(x, y + 0.5) - at(x, y - 0.5);
                    let n_dot_l = normal.dot(to_light);
                    let area = right.cross(down).length() * n_dot_l;
                    let expected = area.sqrt() / texel;
                    let MipmapUniforms { eye, axis, .. } = MipmapUniforms::new(3, &camera);
                    let got = texels_spanned(eye, axis, middle, normal, n_dot_l, texel);
                    assert!(
                        (got / expected - 1.0).abs() < 0.01,
                        "{got} and {expected} at {x}, {y}"
                    );
                    compared += 1;
                }
            }
        }
        assert_eq!(compared, 12);
    }

    /// Levels follow footprints continuously, from the first to the last.
    #[test]
    fn levels_follow_footprints() {
        let cases = [
            (0.3, 4, (0.0, 0.0)),
            (1.0, 4, (0.0, 0.0)),
            (1.5, 4, (0.0, 0.5)),
            (2.0, 4, (1.0, 0.0)),
            (3.0, 4, (1.0, 0.5)),
            (12.0, 4, (3.0, 0.5)),
            (16.0, 4, (4.0, 0.0)),
            (1e9, 4, (4.0, 0.0)),
            (f32::INFINITY, 2, (2.0, 0.0)),
            (f32::NAN, 2, (0.0, 0.0)),
            (5.0, 0, (0.0, 0.0)),
        ];
        for (footprint, levels, expected) in cases {
            assert_eq!(
                mipmap_level(footprint, levels),
                Vec2::from(expected),
                "{footprint}"
            );
        }
    }

    /// Averaged positions of a level have the computed variance. It is counted for a receiver
    /// between two texels, where it is greatest.
    #[test]
    fn coarser_levels_spread_places_as_said() {
        let variance = |level: u32| {
            let side = 1_u32 << level;
            let places = (0..2 * side).map(|i| f64::from(i) + 0.5 - f64::from(side));
            places.map(|place| place * place).sum::<f64>() / f64::from(2 * side)
        };
        for level in 0..4_u32 {
            for share in [0.0, 0.25, 0.75] {
                let mixed = variance(level) * (1.0 - share) + variance(level + 1) * share;
                let said = added_variance(Vec2::new(level as f32, share as f32));
                let added = mixed - variance(0);
                assert!((f64::from(said) - added).abs() < 1e-4, "{said} and {added}");
            }
        }
    }

    #[test]
    fn levels_end_where_maps_are_small() {
        let of = |size| levels(MAX_MIPMAPS, size);
        let sizes = [0, 1, 16, 31, 32, 100, 1024, 4096];
        assert_eq!(sizes.map(of), [0, 0, 0, 0, 1, 2, 6, 6]);
        assert_eq!(levels(2, 1024), 2);
        assert!(check_count(MAX_MIPMAPS).is_ok() && check_count(MAX_MIPMAPS + 1).is_err());
        assert_eq!([0, 1, 2, 3].map(level_reach), [1.0, 2.0, 5.0, 11.0]);
    }
}
