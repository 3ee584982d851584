//! How much each pixel's error counts.

use serde::{Deserialize, Serialize};
use umbrage_core::{Light, Receivers, math::dot3};

/// How much each pixel's error counts in the mean of squares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// All alike.
    #[default]
    Even,
    /// By the square of the light's irradiance, which shading multiplies the mask by: the error is
    /// then the root mean square of the light that arrives too much or too little, over that of all
    /// the light that arrives where nothing casts. A wrong edge counts little where light grazes or
    /// has come far.
    Irradiance,
}

impl Weighting {
    /// Returns each pixel's weight, 0 or more, 1 on average over what receives; 1 everywhere if
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

/// Returns the irradiance of a receiver by the light's middle, in units of the light's own: the
/// cosine between its normal and the light's direction, over the squared distance for lamps, times
/// the cosine at the lamp if that is flat (Lambert's law). A spot's falls off between its angles
/// linearly in the cosine, as [`umbrage_techniques::BlinnPhong`] shades it.
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

    /// Two receivers on a floor below a lamp: one right below, one aside.
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
        // Aside: the cosine is sqrt(1/2), the squared distance 2.
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
