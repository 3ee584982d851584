//! Errors in a narrow part of the image, where one kind of failure shows. A share of the whole
//! image would hide it.

use super::open::share;
use glam::Vec3;
use umbrage_core::{Light, metrics::ERROR_THRESHOLD};

/// A narrow part of the visible geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Band {
    /// Surroundings of the lines in which walls meet.
    Creases {
        /// The ends of each line, world space, metres.
        lines: &'static [[Vec3; 2]],
        /// Greatest distance from a line, metres.
        reach: f32,
    },
    /// The rim of a spot's cone: where the tangent of the angle to its axis is at least this share
    /// of the outer angle's tangent.
    ConeRim {
        /// Share of the outer angle's tangent, 0..=1.
        share: f32,
    },
}

impl Band {
    /// Reports whether a point is in the band, under this light.
    pub fn holds(&self, light: &Light, position: Vec3) -> bool {
        match *self {
            Self::Creases { lines, reach } => lines
                .iter()
                .any(|&[from, to]| distance_to_line(position, from, to) <= reach),
            Self::ConeRim { share } => tangent_share(light, position) >= share,
        }
    }
}

/// Returns the distance of a point from the line between two others.
fn distance_to_line(p: Vec3, from: Vec3, to: Vec3) -> f32 {
    let line = to - from;
    let along = (p - from).dot(line) / line.length_squared();
    let nearest = from + line * along.clamp(0.0, 1.0);
    p.distance(nearest)
}

/// Returns the tangent of the angle between a spot's axis and a point, as a share of its outer
/// angle's; 0 under other lights.
fn tangent_share(light: &Light, position: Vec3) -> f32 {
    let Light::Spot {
        position: apex,
        direction,
        outer,
        ..
    } = *light
    else {
        return 0.0;
    };
    let axis = direction.normalize();
    let from_apex = position - apex;
    let along = from_apex.dot(axis);
    let across = (from_apex - axis * along).length();
    across / (along * outer.tan())
}

/// Returns the percentage of the marked pixels that are wrong by more than [`ERROR_THRESHOLD`].
pub fn wrong_within(mask: &[f32], truth: &[f32], marked: impl Fn(usize) -> bool) -> f64 {
    let marked_pixels = (0..mask.len()).filter(|&i| marked(i));
    share(marked_pixels.map(|i| (mask[i] - truth[i]).abs() > ERROR_THRESHOLD))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creases_are_near_their_lines_alone() {
        let band = Band::Creases {
            lines: &[[Vec3::ZERO, Vec3::X]],
            reach: 0.1,
        };
        let light = Light::Point {
            position: Vec3::ONE,
            radius: 0.0,
        };
        for (place, expected) in [
            (Vec3::new(0.5, 0.09, 0.0), true),
            (Vec3::new(0.5, 0.08, 0.08), false),
            (Vec3::new(1.05, 0.0, 0.0), true),
            (Vec3::new(1.2, 0.0, 0.0), false),
        ] {
            assert_eq!(band.holds(&light, place), expected, "{place}");
        }
    }

    #[test]
    fn the_rim_is_the_outermost_part_of_the_cone() {
        let band = Band::ConeRim { share: 0.9 };
        let spot = Light::Spot {
            position: Vec3::Y * 4.0,
            direction: Vec3::NEG_Y * 3.0,
            inner: 0.1,
            outer: 0.5_f32.atan(),
            radius: 0.0,
        };
        // The disc on the floor has a radius of 2.
        for (place, expected) in [
            (Vec3::X * 1.95, true),
            (Vec3::Z * -1.81, true),
            (Vec3::X * 1.79, false),
            (Vec3::ZERO, false),
        ] {
            assert_eq!(band.holds(&spot, place), expected, "{place}");
        }
        let bulb = Light::Point {
            position: Vec3::Y,
            radius: 0.0,
        };
        assert!(!band.holds(&bulb, Vec3::X), "a point light has no rim");
    }

    #[test]
    fn partial_errors_count_in_the_band_alone() {
        let mask = [1.0, 0.7, 0.8, 0.0];
        let truth = [1.0; 4];
        assert_eq!(wrong_within(&mask, &truth, |i| i < 2), 50.0);
        assert_eq!(wrong_within(&mask, &truth, |i| i == 2), 0.0);
    }
}
