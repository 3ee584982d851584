//! Directions to the sun.

use crate::{FacetsError, Up};
use glam::{DMat3, DVec3};

/// Unit vectors towards the sun, in the caller's axes, with weights.
///
/// Any direction is a sun: the direction of flight for drag, a part of the sky, an observer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Suns {
    directions: Vec<DVec3>,
    weights: Vec<f64>,
}

impl Suns {
    /// Returns suns in these directions, of any length, with weight 1.
    ///
    /// # Errors
    /// Errors with the first direction that is zero or not finite.
    pub fn new(directions: &[DVec3]) -> Result<Self, FacetsError> {
        Self::with_weights(directions, &vec![1.0; directions.len()])
    }

    /// Returns suns in these directions, of any length, with their weights.
    ///
    /// # Errors
    /// Errors with the first direction that is zero or not finite, the first weight that is not
    /// finite, or if there are more or fewer weights than directions.
    pub fn with_weights(directions: &[DVec3], weights: &[f64]) -> Result<Self, FacetsError> {
        if directions.len() != weights.len() {
            let why = format!("are {} for {} suns", weights.len(), directions.len());
            return Err(FacetsError::new("weights", why, "use one for each sun"));
        }
        let units: Vec<DVec3> = directions
            .iter()
            .map(|&direction| unit(direction))
            .collect();
        let is_faulty = |&row: &usize| units[row] == DVec3::ZERO || !weights[row].is_finite();
        if let Some(row) = (0..units.len()).find(is_faulty) {
            let why = format!("is {} with the weight {}", directions[row], weights[row]);
            return Err(FacetsError::new(
                format!("sun {row}"),
                why,
                "use finite vectors, not zero",
            ));
        }
        Ok(Self {
            directions: units,
            weights: weights.to_vec(),
        })
    }

    /// Returns the unit vectors.
    pub fn directions(&self) -> &[DVec3] {
        &self.directions
    }

    /// Returns the weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }
}

/// Returns the unit vector along a vector of any length; zero if it is zero or not finite.
pub(crate) fn unit(vector: DVec3) -> DVec3 {
    // Scale first, so that squares neither overflow nor vanish.
    let scaled = vector / vector.abs().max_element();
    scaled.normalize_or_zero()
}

/// Returns right-handed axes with the third one towards the sun, a unit vector. The matrix maps
/// coordinates along the light to space; its transpose maps back.
pub(crate) fn frame_towards(sun: DVec3) -> DMat3 {
    let (x, y) = sun.any_orthonormal_pair();
    DMat3::from_cols(x, y, sun)
}

/// Returns the unit vector to the sun at an azimuth (degrees, clockwise from north) and a height
/// above the horizon (degrees).
pub fn direction_at(azimuth: f64, height: f64, up: Up) -> DVec3 {
    let (azimuth_sin, azimuth_cos) = azimuth.to_radians().sin_cos();
    let (height_sin, height_cos) = height.to_radians().sin_cos();
    let east = height_cos * azimuth_sin;
    let north = height_cos * azimuth_cos;
    match up {
        Up::Z => DVec3::new(east, north, height_sin),
        Up::Y => DVec3::new(east, height_sin, -north),
    }
}
