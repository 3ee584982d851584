//! The kinds of light. Closed on purpose: a new kind must be met by everything that matches on it.

use crate::invalid::{Invalid, direction, finite, not_negative, positive};
use glam::Vec3;

/// A light. Lights with an extent emit from all of it, to both sides, and are seen as a fraction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Light {
    /// Infinitely far.
    Directional {
        /// The way light travels; any length.
        direction: Vec3,
        /// Full angle of the light's disc in the sky, radians; 0 for an ideal light. The sun's is
        /// .0093.
        angular_diameter: f32,
    },
    /// Shines within a cone.
    Spot {
        /// Where it is.
        position: Vec3,
        /// The cone's axis; any length.
        direction: Vec3,
        /// Half angle of full light, radians.
        inner: f32,
        /// Half angle where light ends, radians, below pi/2.
        outer: f32,
        /// Radius of the disc across the axis that emits, metres; 0 for an ideal light.
        radius: f32,
    },
    /// Shines every way.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radius of the ball that emits, metres; 0 for an ideal light. Seen from a receiver it
        /// counts as the disc through its centre that faces the receiver.
        radius: f32,
    },
    /// A rectangle (more exactly, a parallelogram).
    Rect {
        /// Its middle.
        center: Vec3,
        /// From the middle to the middle of one side.
        half_u: Vec3,
        /// From the middle to the middle of a neighbouring side.
        half_v: Vec3,
    },
    /// A flat disc.
    Disc {
        /// Its middle.
        center: Vec3,
        /// Across the disc; any length.
        normal: Vec3,
        /// Metres, greater than zero.
        radius: f32,
    },
}

impl Light {
    /// The kind's name, as scene files have it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Directional { .. } => "directional",
            Self::Spot { .. } => "spot",
            Self::Point { .. } => "point",
            Self::Rect { .. } => "rect",
            Self::Disc { .. } => "disc",
        }
    }

    /// Returns whether every receiver sees the light whole or not at all.
    pub fn is_ideal(&self) -> bool {
        match *self {
            Self::Directional {
                angular_diameter, ..
            } => angular_diameter == 0.0,
            Self::Spot { radius, .. } | Self::Point { radius, .. } => radius == 0.0,
            Self::Rect { .. } | Self::Disc { .. } => false,
        }
    }

    /// Returns the ideal light in this one's middle: itself without an extent, or a point light in
    /// the place of an area.
    #[must_use]
    pub fn without_extent(&self) -> Self {
        match *self {
            Self::Directional { direction, .. } => Self::Directional {
                direction,
                angular_diameter: 0.0,
            },
            Self::Spot {
                position,
                direction,
                inner,
                outer,
                ..
            } => Self::Spot {
                position,
                direction,
                inner,
                outer,
                radius: 0.0,
            },
            Self::Point { position, .. }
            | Self::Rect {
                center: position, ..
            }
            | Self::Disc {
                center: position, ..
            } => Self::Point {
                position,
                radius: 0.0,
            },
        }
    }

    /// Returns the light's middle, world space; `None` for a directional light.
    pub fn position(&self) -> Option<Vec3> {
        match *self {
            Self::Directional { .. } => None,
            Self::Spot { position, .. } | Self::Point { position, .. } => Some(position),
            Self::Rect { center, .. } | Self::Disc { center, .. } => Some(center),
        }
    }

    /// Returns the same light with its middle elsewhere, world space; a directional light stays as
    /// it is.
    #[must_use]
    pub fn moved_to(mut self, to: Vec3) -> Self {
        match &mut self {
            Self::Directional { .. } => {}
            Self::Spot { position, .. } | Self::Point { position, .. } => *position = to,
            Self::Rect { center, .. } | Self::Disc { center, .. } => *center = to,
        }
        self
    }

    /// Returns the unit direction from `p` to the light's middle.
    pub fn direction_from(&self, p: Vec3) -> Vec3 {
        let to_light = match *self {
            Self::Directional { direction, .. } => -direction.as_dvec3(),
            Self::Spot { position, .. } | Self::Point { position, .. } => (position - p).as_dvec3(),
            Self::Rect { center, .. } | Self::Disc { center, .. } => (center - p).as_dvec3(),
        };
        to_light.normalize_or_zero().as_vec3()
    }

    /// Checks that the light can be used.
    ///
    /// # Errors
    /// Errors with the light's kind and the first fault found: a number that is not finite, a zero
    /// direction, a negative size, an impossible angle.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.validate_fields()
            .map_err(|e| e.within(format!("{} light", self.kind())))
    }

    fn validate_fields(&self) -> Result<(), Invalid> {
        if let Some(p) = self.position() {
            finite("position", &p.to_array())?;
        }
        match *self {
            Self::Directional {
                direction: d,
                angular_diameter,
            } => {
                direction("direction", d)?;
                angle("angular diameter", angular_diameter, 180.0)
            }
            Self::Spot {
                direction: d,
                inner,
                outer,
                radius,
                ..
            } => {
                direction("direction", d)?;
                not_negative("radius", radius)?;
                positive("outer angle", outer)?;
                angle("outer angle", outer, 90.0)?;
                angle("inner angle", inner, 90.0)?;
                if inner <= outer {
                    return Ok(());
                }
                let why = format!(
                    "is {} degrees, the outer one {}",
                    inner.to_degrees(),
                    outer.to_degrees()
                );
                Err(Invalid::new(
                    "inner angle",
                    why,
                    "make the inner angle the smaller",
                ))
            }
            Self::Point { radius, .. } => not_negative("radius", radius),
            Self::Rect { half_u, half_v, .. } => {
                direction("half_u", half_u)?;
                direction("half_v", half_v)?;
                let normal = half_u.as_dvec3().cross(half_v.as_dvec3());
                direction("half_u x half_v", normal.normalize_or_zero().as_vec3())
            }
            Self::Disc { normal, radius, .. } => {
                direction("normal", normal)?;
                positive("radius", radius)
            }
        }
    }
}

fn angle(what: &str, radians: f32, below: f32) -> Result<(), Invalid> {
    finite(what, &[radians])?;
    let degrees = radians.to_degrees();
    if radians >= 0.0 && degrees < below {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        format!("is {degrees} degrees"),
        format!("use 0 to less than {below}"),
    ))
}
