//! Bounds on the difference between devices in the depths of one triangle, and shifts by that
//! amount.

use glam::DVec3;

/// Shift of the triangles' depths by parts of the rounding bound, to find results that depend on
/// rounding. Triangles with even and odd ids may move in opposite directions, so that coplanar
/// surfaces swap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneShift {
    /// Part of the bound for triangles with even ids, -1..=1; positive is away from the light.
    pub even: f32,
    /// Part of the bound for triangles with odd ids.
    pub odd: f32,
}

impl PlaneShift {
    /// No shift.
    pub const NONE: Self = Self {
        even: 0.0,
        odd: 0.0,
    };

    /// Returns the part for a triangle.
    pub(crate) fn for_triangle(self, id: u32) -> f32 {
        if id.is_multiple_of(2) {
            self.even
        } else {
            self.odd
        }
    }
}

/// Window coordinate above which devices can't be modelled: in steps of 1/16 pixel it doesn't fit
/// 32 bits.
const MAX_PLACE: f64 = 134_217_728.0;

/// Factor on the sum in [`plane_error`]. Over 100,000 random triangles, the error of a plane
/// evaluated in 32 bits was below 4 times the sum. Two devices may deviate in opposite directions.
const ERRORS: f64 = 2.0 * 4.0;

/// Returns the greatest difference between two devices' depths of a triangle within an image, at
/// most 1, the whole range.
///
/// Each device evaluates the plane through the corners (window space, pixels and depth) in 32 bits,
/// from an origin of its choice. The error grows with the plane's change up to the origin. It also
/// grows with the plane's change over the triangle times the condition of the area, which is a
/// difference of two products: slivers have almost no area. If a corner is so close to the eye's
/// plane that it has no window position, any depth may be drawn.
pub(crate) fn plane_error(corners: [DVec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let least = a.min(b).min(c);
    let greatest = a.max(b).max(c);
    let reach = greatest.abs().max(least.abs());
    let span = greatest - least;
    let normal = (b - a).cross(c - a);
    let change_x = (normal.x / normal.z).abs();
    let change_y = (normal.y / normal.z).abs();
    // Devices start from a corner of their choice.
    let condition = products(a, b, c)
        .max(products(b, c, a))
        .max(products(c, a, b))
        / normal.z.abs();
    let to_origin = change_x * reach.x + change_y * reach.y;
    let across = change_x * span.x + change_y * span.y;
    let rounding = 0.5 * f64::from(f32::EPSILON);
    let error = ERRORS * rounding * (1.0 + to_origin + condition * across);
    let has_a_place = reach.x.max(reach.y) < MAX_PLACE;
    if error.is_finite() && has_a_place {
        error.min(1.0) as f32
    } else {
        1.0
    }
}

/// Returns the sum of the magnitudes of the two products whose difference is a triangle's doubled
/// area, computed from corner `a`.
fn products(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let d = b - a;
    let e = c - a;
    (d.x * e.y).abs() + (d.y * e.x).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a right triangle whose depth grows to the right by 1/128 per pixel.
    fn triangle(left: f64) -> [DVec3; 3] {
        [
            DVec3::new(left, 0.0, 0.0),
            DVec3::new(left + 64.0, 64.0, 0.5),
            DVec3::new(left, 64.0, 0.0),
        ]
    }

    #[test]
    fn slivers_and_far_corners_err_more() {
        let plain = plane_error(triangle(0.0));
        let sliver = plane_error([
            DVec3::ZERO,
            DVec3::new(64.0, 64.0, 0.5),
            DVec3::new(32.0, 32.001, 0.3),
        ]);
        let far = plane_error(triangle(1e6));
        assert!(plain < 1e-5, "{plain}");
        // Without the condition of its area, the bound would be below a hundredth.
        assert_eq!(sliver, 1.0);
        assert!(far > 100.0 * plain, "{far}");
    }

    #[test]
    fn what_has_no_place_may_be_anything() {
        // Without a slope, only the position causes the error.
        let flat = triangle(1e9).map(|corner| corner.with_z(0.5));
        assert_eq!(plane_error(flat), 1.0);
        assert_eq!(plane_error([DVec3::NAN; 3]), 1.0);
        assert_eq!(plane_error([DVec3::ONE; 3]), 1.0);
    }
}
