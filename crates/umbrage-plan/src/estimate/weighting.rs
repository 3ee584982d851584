//! Weight of each pixel's error.

use serde::{Deserialize, Serialize};
use umbrage_core::{Light, Receivers, math::dot3};

/// Weight of each pixel's error in the mean of squares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// All pixels have the same weight.
    #[default]
    Even,
    /// Square of the light's irradiance, which shading multiplies by the mask. The error is the
    /// root mean square of excess or missing light, relative to all light without casters. A wrong
    /// edge counts little at grazing or distant light.
    Irradiance,
}

impl Weighting {
    /// Returns each pixel's weight, 0 or more, 1 on average over receivers. Returns 1 everywhere if
    /// nothing is lit.
    pub(crate) fn weights(self, light: &Light, receivers: &Receivers) -> Vec<f64> {
        let even = vec![1.0; receivers.len()];
        if self == Self::Even {
            return even;
        }
        let squares: Vec<f64> = (0..receivers.len())
            .map(|i| match receivers.receives[i] {
                true => irradiance(light, receivers, i).powi(2),
                false => 0.0,
            })
            .collect();
        let sum: f64 = squares.iter().sum();
        let count = receivers.receives.iter().filter(|r| **r).count() as f64;
        if sum > 0.0 && sum.is_finite() {
            squares.into_iter().map(|s| s * count / sum).collect()
        } else {
            even
        }
    }
}

/// Returns the irradiance of a receiver from the light's centre, in units of the light's intensity.
///
/// It is the cosine between the normal and the light's direction. For lights with a position it is
/// divided by the squared distance, and for flat lights multiplied by the cosine at the light
/// (Lambert's law). A spot falls off between its angles linearly in the cosine, as in
/// [`umbrage_techniques::BlinnPhong`].
fn irradiance(light: &Light, receivers: &Receivers, i: usize) -> f64 {
    let position = receivers.position(i);
    let to_light = light.direction_from(position);
    let cosine = f64::from(dot3(receivers.normal(i), to_light).max(0.0));
    let Some(middle) = light.position() else {
        return cosine;
    };
    let squared_distance = f64::from((middle - position).length_squared()).max(f64::MIN_POSITIVE);
    let emitted = match *light {
        Light::Spot {
            direction,
            inner,
            outer,
            ..
        } => {
            let at_lamp = dot3(direction.normalize(), -to_light);
            let full = inner.cos();
            let none = outer.cos();
            ((at_lamp - none) / (full - none).max(1e-6)).clamp(0.0, 1.0)
        }
        Light::Rect { half_u, half_v, .. } => {
            let normal = half_u.cross(half_v).normalize();
            dot3(normal, to_light).abs()
        }
        Light::Disc { normal, .. } => dot3(normal.normalize(), to_light).abs(),
        Light::Directional { .. } | Light::Point { .. } => 1.0,
    };
    cosine * f64::from(emitted) / squared_distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{UVec2, Vec3};

    /// Returns two receivers on a floor below a light: one directly below, one to the side.
    fn floor(points: [Vec3; 2]) -> Receivers {
        let mut out = Receivers::empty(UVec2::new(2, 1));
        for (i, p) in points.into_iter().enumerate() {
            (out.x[i], out.y[i], out.z[i]) = (p.x, p.y, p.z);
            (out.nx[i], out.ny[i], out.nz[i]) = (0.0, 1.0, 0.0);
            out.receives[i] = true;
        }
        out
    }

    #[test]
    fn light_falls_off_with_distance_and_cosine() {
        let bulb = Light::Point {
            position: Vec3::Y,
            radius: 0.0,
        };
        let receivers = floor([Vec3::ZERO, Vec3::X]);
        // To the side, the cosine is sqrt(1/2) and the squared distance 2.
        let [below, aside] = [0, 1].map(|i| irradiance(&bulb, &receivers, i));
        assert!((below - 1.0).abs() < 1e-6 && (aside - 0.5_f64.sqrt() / 2.0).abs() < 1e-6);
        let lamp = Light::Disc {
            center: Vec3::Y,
            normal: -Vec3::Y,
            radius: 0.1,
        };
        let aside_of_lamp = irradiance(&lamp, &receivers, 1);
        assert!((aside_of_lamp - 0.25).abs() < 1e-6, "{aside_of_lamp}");
    }

    #[test]
    fn weights_are_squares_with_a_mean_of_one() {
        let bulb = Light::Point {
            position: Vec3::Y,
            radius: 0.0,
        };
        let receivers = floor([Vec3::ZERO, Vec3::X]);
        let weights = Weighting::Irradiance.weights(&bulb, &receivers);
        assert!((weights.iter().sum::<f64>() - 2.0).abs() < 1e-9);
        assert!((weights[0] / weights[1] - 8.0).abs() < 1e-5, "{weights:?}");
        assert_eq!(Weighting::Even.weights(&bulb, &receivers), [1.0, 1.0]);
        let behind = floor([2.0 * Vec3::Y; 2]);
        assert_eq!(Weighting::Irradiance.weights(&bulb, &behind), [1.0, 1.0]);
    }
}
