//! The kinds of light. The enum is exhaustive on purpose: matches must handle every kind.

use crate::invalid::{Invalid, direction, finite, not_negative, positive};
use glam::Vec3;

/// A light. Area lights emit from their whole area, to both sides, and may be partially visible.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Light {
    /// At infinity.
    Directional {
        /// Direction of the light's travel; any length.
        direction: Vec3,
        /// Full angle of the light's disc in the sky, radians; 0 for an ideal light. The sun's is
        /// 0.0093.
        angular_diameter: f32,
    },
    /// Emits within a cone.
    Spot {
        /// Position.
        position: Vec3,
        /// Axis of the cone; any length.
        direction: Vec3,
        /// Half angle of the fully lit cone, radians.
        inner: f32,
        /// Half angle of the whole cone, radians, below pi/2.
        outer: f32,
        /// Radius of the emitting disc, which is perpendicular to the axis, metres; 0 for an ideal
        /// light.
        radius: f32,
    },
    /// Emits in all directions.
    Point {
        /// Position.
        position: Vec3,
        /// Radius of the emitting sphere, metres; 0 for an ideal light. For each receiver, it is
        /// approximated by the disc through its centre that faces the receiver.
        radius: f32,
    },
    /// A rectangle (more generally, a parallelogram).
    Rect {
        /// Centre.
        center: Vec3,
        /// Vector from the centre to the midpoint of one side.
        half_u: Vec3,
        /// Vector from the centre to the midpoint of a neighbouring side.
        half_v: Vec3,
    },
    /// A flat disc.
    Disc {
        /// Centre.
        center: Vec3,
        /// Normal of the disc; any length.
        normal: Vec3,
        /// Radius, metres, greater than zero.
        radius: f32,
    },
}

impl Light {
    /// Returns the kind's name, as in scene files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Directional { .. } => "directional",
            Self::Spot { .. } => "spot",
            Self::Point { .. } => "point",
            Self::Rect { .. } => "rect",
            Self::Disc { .. } => "disc",
        }
    }

    /// Returns whether every receiver sees all of the light or nothing.
    pub fn is_ideal(&self) -> bool {
        match *self {
            Self::Directional {
                angular_diameter, ..
            } => angular_diameter == 0.0,
            Self::Spot { radius, .. } | Self::Point { radius, .. } => radius == 0.0,
            Self::Rect { .. } | Self::Disc { .. } => false,
        }
    }

    /// Returns the ideal light at this one's centre: the same kind without extent, or a point light
    /// instead of a rectangle or disc.
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

    /// Returns the centre of the light, world space; `None` for a directional light.
    pub fn position(&self) -> Option<Vec3> {
        match *self {
            Self::Directional { .. } => None,
            Self::Spot { position, .. } | Self::Point { position, .. } => Some(position),
            Self::Rect { center, .. } | Self::Disc { center, .. } => Some(center),
        }
    }

    /// Returns the light with its centre moved to `to`, world space; a directional light is
    /// unchanged.
    #[must_use]
    pub fn moved_to(mut self, to: Vec3) -> Self {
        match &mut self {
            Self::Directional { .. } => {}
            Self::Spot { position, .. } | Self::Point { position, .. } => *position = to,
            Self::Rect { center, .. } | Self::Disc { center, .. } => *center = to,
        }
        self
    }

    /// Returns the unit direction from `p` to the centre of the light.
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
            .map_err(|e| e.within_context(format!("{} light", self.kind())))
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
                    "is {} degrees, and the outer angle is {}",
                    inner.to_degrees(),
                    outer.to_degrees()
                );
                Err(Invalid::new(
                    "inner angle",
                    why,
                    "make the inner angle at most the outer angle",
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
