//! Depth error caused by the rounding of positions. It grows with the distance from the origin.

use umbrage_core::{
    LightSpace,
    glam::{DMat4, DVec3},
};

/// Fraction of a position's greatest coordinate that rounding can change before its depth is
/// compared. Each rounding is half a unit in the last place (2^-24). There are eight: following the
/// receiver's ray, placing the caster's corner, and each sum of both transforms. The result is
/// doubled, because a lateral error also moves a point up or down a slope.
const PART_OF_COORDINATE: f64 = 1.0 / (1 << 20) as f64;

/// Returns the depth error of an orthographic space, clip depth, for positions in its box. Returns
/// 0 with perspective: a depth step there has a different length at each distance, so no constant
/// fits.
pub(crate) fn depth_error(space: &LightSpace) -> f32 {
    let projection = space.clip_from_view;
    if projection.z_axis.w != 0.0 {
        return 0.0;
    }
    let world_from_clip: DMat4 = space.clip_from_world().as_dmat4().inverse();
    let mut greatest_coordinate = 0.0_f64;
    for x in [-1.0, 1.0] {
        for y in [-1.0, 1.0] {
            for z in [0.0, 1.0] {
                let corner = world_from_clip.project_point3(DVec3::new(x, y, z));
                greatest_coordinate = greatest_coordinate.max(corner.abs().max_element());
            }
        }
    }
    let depth_per_metre = f64::from(projection.z_axis.z.abs());
    let rounding = greatest_coordinate * PART_OF_COORDINATE * depth_per_metre;
    // Depths are 0 to 1, so a greater bias has no further effect.
    rounding.clamp(0.0, 1.0) as f32
}

/// Clip depth per ratio of the near to the far plane. At a ratio of 2^-14, the least of all fits, it
/// gives four steps of the depths next to 1, and a gap of z / 256 of the far plane's distance at the
/// fraction z of it.
const CONSTANT_PER_NEAR_OVER_FAR: f32 = 1.0 / 256.0;

/// Returns the greatest constant bias, clip depth, that moves no shadow visibly. Infinite for
/// orthographic spaces.
///
/// With perspective, a clip depth d at the distance z is d z² (1 / near - 1 / far) metres. With a
/// near plane of millimetres, 1e-5 would be half a metre.
pub(crate) fn greatest_constant(space: &LightSpace) -> f32 {
    let projection = space.clip_from_view;
    if projection.z_axis.w == 0.0 {
        return f32::INFINITY;
    }
    // The z axis has the z of -far / (far - near).
    let near_over_far = 1.0 + 1.0 / projection.z_axis.z;
    CONSTANT_PER_NEAR_OVER_FAR * near_over_far.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::glam::{Mat4, Vec3, Vec4};

    /// Returns a space that looks along -z, 10 m wide and 20 m deep.
    fn sun(away: f32) -> LightSpace {
        let depth = Vec4::new(0.0, 0.0, -1.0 / 20.0, 0.0);
        let clip_from_view = Mat4::from_cols(Vec4::X / 5.0, Vec4::Y / 5.0, depth, Vec4::W);
        LightSpace {
            view_from_world: Mat4::from_translation(Vec3::new(-away, 0.0, -10.0)),
            clip_from_view,
        }
    }

    #[test]
    fn it_grows_with_the_distance_from_the_origin() {
        let [near, far] = [0.0, 10_000.0].map(|away| depth_error(&sun(away)));
        assert!(near < 1e-6, "{near}");
        // The rounding is 10 km / 2^20, relative to 20 m of depth.
        assert!(
            (far / (10_005.0 / 1_048_576.0 / 20.0) - 1.0).abs() < 1e-3,
            "{far}"
        );
    }

    #[test]
    fn with_perspective_there_is_none() {
        let depth = Vec4::new(0.0, 0.0, -1.0, -1.0);
        let clip_from_view =
            Mat4::from_cols(Vec4::X, Vec4::Y, depth, Vec4::new(0.0, 0.0, -0.1, 0.0));
        assert_eq!(
            depth_error(&LightSpace {
                clip_from_view,
                ..sun(1e6)
            }),
            0.0
        );
    }

    #[test]
    fn a_constant_moves_no_shadow_by_much_however_near_the_near_plane_is() {
        let far = 38.0_f32;
        for near in [0.0024, 0.05, 0.5, 5.0] {
            let clip_from_view = Mat4::from_cols(
                Vec4::X,
                Vec4::Y,
                Vec4::new(0.0, 0.0, far / (near - far), -1.0),
                Vec4::new(0.0, 0.0, near * far / (near - far), 0.0),
            );
            let space = LightSpace {
                clip_from_view,
                ..sun(0.0)
            };
            let constant = greatest_constant(&space).min(1e-5);
            // Metres by which the constant moves a surface 13 m away.
            let gap = constant * 13.0 * 13.0 * (1.0 / near - 1.0 / far);
            assert!(gap < 0.05, "{near}: {gap}");
            // Depths next to 1 have steps of 2^-24.
            assert!(constant >= 3.0 * 2.0_f32.powi(-24), "{near}: {constant}");
        }
        assert_eq!(greatest_constant(&sun(0.0)), f32::INFINITY);
    }
}
