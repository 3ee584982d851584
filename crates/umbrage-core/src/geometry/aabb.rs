//! Axis-aligned boxes.

use crate::invalid::{self, Invalid};
use glam::{BVec3, Vec3};

/// An axis-aligned box; empty when `min > max` in any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The empty box.
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// Returns the smallest box around the points. A NaN coordinate makes the box NaN, so that
    /// [`Aabb::validate`] fails.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |b, p| b.union(&Self { min: p, max: p }))
    }

    /// Returns whether the box is empty; also true if it contains NaN.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Checks that all numbers are finite, or the box is [`Aabb::EMPTY`].
    ///
    /// # Errors
    /// Errors if a number is not finite.
    pub fn validate(&self) -> Result<(), Invalid> {
        if *self == Self::EMPTY {
            return Ok(());
        }
        invalid::finite("box's min", &self.min.to_array())?;
        invalid::finite("box's max", &self.max.to_array())
    }

    /// Returns the smallest box around both; NaN is kept.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: lesser(self.min, other.min),
            max: -lesser(-self.max, -other.max),
        }
    }

    /// Returns the intersection of both boxes, which may be empty.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// Returns the centre of the box; meaningless for an empty one.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Returns the edge lengths; zero for an empty box.
    pub fn extent(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Returns the length of the diagonal. Finite whenever the box is, although squares of lengths
    /// beyond 1e19 m overflow.
    pub fn diagonal(&self) -> f32 {
        let extent = self.extent();
        let length = extent.length();
        if length.is_finite() {
            length
        } else {
            extent.as_dvec3().length().min(f64::from(f32::MAX)) as f32
        }
    }

    /// Returns the eight corners; no corners for an empty box.
    pub fn corners(&self) -> impl Iterator<Item = Vec3> + use<> {
        let b = *self;
        let count = if self.is_empty() { 0 } else { 8 };
        (0..count).map(move |i| {
            // Bits 0, 1 and 2 of the corner's index select the greatest x, y and z.
            let is_max = BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
            Vec3::select(is_max, b.max, b.min)
        })
    }
}

/// Returns the componentwise minimum, NaN if either operand is. `min` would drop NaN, and the box
/// around it would be empty.
fn lesser(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::select(a.is_nan_mask() | a.cmplt(b), a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_around_numbers_that_are_none_are_refused() {
        let good = Vec3::new(1.0, -2.0, 3.0);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for points in [
                vec![good.with_y(bad)],
                vec![good, good.with_x(bad), -good],
                vec![good.with_z(bad), good],
            ] {
                let error = Aabb::from_points(points).validate().unwrap_err();
                assert!(error.to_string().contains("box's m"), "{error}");
            }
        }
        let one = Aabb::from_points([good, -good]);
        let none = Aabb {
            min: Vec3::NAN,
            max: Vec3::NAN,
        };
        assert!(one.union(&none).validate().is_err() && none.union(&one).validate().is_err());
        assert!(one.validate().is_ok() && Aabb::EMPTY.validate().is_ok());
        assert_eq!(one.union(&Aabb::EMPTY), one);
    }
}
