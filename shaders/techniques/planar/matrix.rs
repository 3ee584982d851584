//! Textbook matrix that projects points from a light onto a plane.

use glam::{DMat4, DVec4, Mat4, Vec4};

/// Returns the matrix that maps homogeneous points to their shadows on `plane`:
/// `(plane . light) I - light plane^T`. Blinn 1988, "Me and my (fake) shadow" (Jim Blinn's corner,
/// IEEE CG&A 8.1).
///
/// `plane` is (n, d) with `n . p + d = 0` on it, n of any length. `light` is a position (w = 1) or
/// the direction to the light (w = 0). The results are homogeneous, too: divide by w. For a plane
/// turned to the light, w is positive if there is a shadow. It is negative for points above the
/// light, whose mirror image on the plane is the well-known anti-shadow. Points below the plane are
/// projected up to it. So casters must be clipped to the slab between plane and light first.
pub fn planar_shadow_matrix(plane: Vec4, light: Vec4) -> Mat4 {
    exact(plane.as_dvec4(), light.as_dvec4()).as_mat4()
}

/// Returns [`planar_shadow_matrix`] before rounding to 32 bits.
pub(crate) fn exact(plane: DVec4, light: DVec4) -> DMat4 {
    let outer = DMat4::from_cols(
        light * plane.x,
        light * plane.y,
        light * plane.z,
        light * plane.w,
    );
    DMat4::from_diagonal(DVec4::splat(plane.dot(light))) - outer
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the shadow of a point.
    fn shadow(plane: Vec4, light: Vec4, x: f32, y: f32, z: f32) -> [f32; 3] {
        let p = planar_shadow_matrix(plane, light) * Vec4::new(x, y, z, 1.0);
        (p / p.w).truncate().to_array()
    }

    #[test]
    fn shadows_fall_where_a_pencil_puts_them() {
        let floor = Vec4::new(0.0, 1.0, 0.0, 0.0);
        // Directional light at 45 degrees: the offset equals the height.
        assert_eq!(
            shadow(floor, Vec4::new(1.0, 1.0, 0.0, 0.0), 2.0, 3.0, 5.0),
            [-1.0, 0.0, 5.0]
        );
        // Light 4 m up, point 1 m up: four thirds of its distance from below the light.
        assert_eq!(
            shadow(floor, Vec4::new(1.0, 4.0, 0.0, 1.0), 4.0, 1.0, 3.0),
            [5.0, 0.0, 4.0]
        );
        // Wall at x = 2, with its plane scaled by two, and the light at the origin.
        let wall = Vec4::new(-2.0, 0.0, 0.0, 4.0);
        assert_eq!(shadow(wall, Vec4::W, 1.0, 0.5, -1.0), [2.0, 1.0, -2.0]);
    }

    #[test]
    fn points_of_the_plane_stay_and_points_above_the_lamp_turn_negative() {
        let floor = Vec4::new(0.0, 1.0, 0.0, -1.0);
        let lamp = Vec4::new(0.0, 3.0, 0.0, 1.0);
        assert_eq!(shadow(floor, lamp, 7.0, 1.0, -2.0), [7.0, 1.0, -2.0]);
        assert!((planar_shadow_matrix(floor, lamp) * Vec4::new(1.0, 5.0, 0.0, 1.0)).w < 0.0);
        // A point level with the light has its shadow at infinity.
        assert_eq!(
            (planar_shadow_matrix(floor, lamp) * Vec4::new(1.0, 3.0, 0.0, 1.0)).w,
            0.0
        );
    }
}
