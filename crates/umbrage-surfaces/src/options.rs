//! Settings: axes, units, sides and tolerances.

use std::str::FromStr;

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// y is up, z is south, x is east: glTF, OBJ.
    Y,
    /// z is up, y is north, x is east: CAD, GIS, IFC.
    Z,
}

/// Reads `y` or `z`.
impl FromStr for Up {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            _ => Err(format!("up is `{text}`; use `y` or `z`")),
        }
    }
}

/// The unit of the caller's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// Metres, but not stated: lengths that metres make improbable are an error.
    Unstated,
    /// A unit of this many metres, as stated by the caller. Any length is accepted.
    Metres(f64),
}

impl Unit {
    /// Returns the metres of one unit.
    pub fn metres(self) -> f64 {
        match self {
            Self::Unstated => 1.0,
            Self::Metres(metres) => metres,
        }
    }
}

/// Reads `m`, `cm`, `mm`, `km`, `ft`, `in`, or the metres of one unit as a number.
impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let metres = match text {
            "m" => 1.0,
            "cm" => 0.01,
            "mm" => 0.001,
            "km" => 1000.0,
            "ft" => 0.3048,
            "in" => 0.0254,
            _ => text.parse().unwrap_or(f64::NAN),
        };
        if metres > 0.0 && f64::is_finite(metres) {
            Ok(Self::Metres(metres))
        } else {
            Err(format!(
                "`{text}` is no unit; use m, cm, mm, km, ft, in, or metres per unit"
            ))
        }
    }
}

/// The sides of facets that receive light and cast shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// The front, from which corners are counter-clockwise. Facets that face away from the sun are
    /// dark and are not searched for. It needs closed bodies that face outwards, and is about twice
    /// as fast as both sides.
    Front,
    /// Both sides, for meshes that may be open.
    Both,
}

/// Reads `front` or `both`.
impl FromStr for Sides {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "front" => Ok(Self::Front),
            "both" => Ok(Self::Both),
            _ => Err(format!("sides is `{text}`; use `front` or `both`")),
        }
    }
}

/// Settings of [`Facets`](crate::Facets).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The axis that points up: for azimuths and for the horizon.
    pub up: Up,
    /// Unit of the coordinates.
    pub unit: Unit,
    /// Sides that receive and cast.
    pub sides: Sides,
    /// Greatest accepted margin of answers, metres: see
    /// [`Facets::margin_m`](crate::Facets::margin_m).
    pub max_error_m: f64,
    /// True to compute [`Stated::identity`](crate::Stated::identity) of lit areas, which takes
    /// about as long as the areas.
    pub certify: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            up: Up::Z,
            unit: Unit::Unstated,
            sides: Sides::Both,
            max_error_m: 1e-5,
            certify: false,
        }
    }
}
