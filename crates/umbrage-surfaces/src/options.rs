//! Settings: axes, units, sides and tolerances.

use glam::DVec3;
use std::str::FromStr;

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// y is up, z is south, x is east: glTF, OBJ.
    Y,
    /// z is up, y is north, x is east: CAD, GIS, IFC.
    Z,
}

impl Up {
    /// Returns the height of a vector.
    pub fn height(self, vector: DVec3) -> f64 {
        match self {
            Self::Y => vector.y,
            Self::Z => vector.z,
        }
    }
}

/// Reads `y` or `z`.
impl FromStr for Up {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let up = find_name(text, &[("y", Self::Y), ("z", Self::Z)]);
        up.ok_or_else(|| format!("up is `{text}`; use `y` or `z`"))
    }
}

/// Returns the metres of a unit: `m`, `cm`, `mm`, `km`, `ft`, `in`, or metres as a number.
///
/// # Errors
/// Errors if the text is none of these, or if the number is not finite or not greater than zero.
pub fn metres_of_unit(text: &str) -> Result<f64, String> {
    let units = [
        ("m", 1.0),
        ("cm", 0.01),
        ("mm", 0.001),
        ("km", 1000.0),
        ("ft", 0.3048),
        ("in", 0.0254),
    ];
    let metres = find_name(text, &units).or_else(|| text.parse::<f64>().ok());
    let metres = metres.filter(|metres| *metres > 0.0 && metres.is_finite());
    metres.ok_or_else(|| {
        format!("`{text}` is no unit; use m, cm, mm, km, ft, in, or metres per unit")
    })
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
        let sides = find_name(text, &[("front", Self::Front), ("both", Self::Both)]);
        sides.ok_or_else(|| format!("sides is `{text}`; use `front` or `both`"))
    }
}

/// Returns the value of a name; `None` if it is unknown.
fn find_name<T: Copy>(text: &str, names: &[(&str, T)]) -> Option<T> {
    let found = names.iter().find(|(name, _)| *name == text);
    found.map(|&(_, value)| value)
}

/// Settings of [`Facets`](crate::Facets).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The axis that points up: for azimuths and for the horizon.
    pub up: Up,
    /// Metres of one unit of the coordinates. `None`: metres, but lengths that metres make
    /// improbable are an error.
    pub unit_m: Option<f64>,
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
            unit_m: None,
            sides: Sides::Both,
            max_error_m: 1e-5,
            certify: false,
        }
    }
}
