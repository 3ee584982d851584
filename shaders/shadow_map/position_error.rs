//! The error of depths that comes from the rounding of positions. It grows with the distance from
//! the origin.

use umbrage_core::{
    LightSpace,
    glam::{DMat4, DVec3},
};

/// What a position's rounding takes of its greatest coordinate by the time that its depth is
/// compared: half a unit in the last place (2^-24) where the receiver's ray is followed, where the
/// caster's corner is placed, and for each of the sums of both's transforms, eight in all; as much
/// again since what rounding moves aside goes up or down a slope, too.
const PART_OF_COORDINATE: f64 = 1.0 / (1 << 20) as f64;

/// Returns the error of depths in a space without perspective, clip depth, for positions in the box
/// that the space maps. With perspective 0: there a depth is worth other lengths at each distance,
/// and no constant is right.
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
    // Depths are 0 to 1: more than all of it is no bias.
    rounding.clamp(0.0, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::glam::{Mat4, Vec3, Vec4};

    /// Looks along -z, 10 m wide and 20 m deep.
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
        // 10 km / 2^20, of 20 m of depth.
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
}
