//! Errors within penumbrae, and errors of their widths.
//!
//! Over a penumbra that rises linearly from 0 to 1 over a width w, the integral of v (1 - v) is
//! w / 6. Pixels have equal weights in mask and truth, so their sums of v (1 - v) have the ratio of
//! the widths, without edge detection. Dithering with n equal taps takes 1/n off the sum.

use glam::Vec3;
use umbrage_core::{Receivers, metrics::is_penumbra};

/// Returns the RMSE over the pixels in truth's penumbrae; 0 without any.
pub fn rmse(mask: &[f32], truth: &[f32], counts: impl Fn(usize) -> bool) -> f64 {
    root_mean(mask.len(), truth, counts, |i| {
        (f64::from(mask[i]) - f64::from(truth[i])).powi(2)
    })
}

/// Returns the RMSE that `rays` independent rays a pixel would have over the same pixels: binomial,
/// v (1 - v) / n each.
pub fn ray_noise(truth: &[f32], rays: u32, counts: impl Fn(usize) -> bool) -> f64 {
    root_mean(truth.len(), truth, counts, |i| {
        f64::from(truth[i]) * f64::from(1.0 - truth[i]) / f64::from(rays)
    })
}

/// Returns the square root of the mean of `square` over the counted pixels in truth's penumbrae.
fn root_mean(
    len: usize,
    truth: &[f32],
    counts: impl Fn(usize) -> bool,
    square: impl Fn(usize) -> f64,
) -> f64 {
    let in_penumbra: Vec<usize> = (0..len)
        .filter(|&i| counts(i) && is_penumbra(truth[i]))
        .collect();
    let sum = in_penumbra.iter().map(|&i| square(i)).sum::<f64>();
    (sum / in_penumbra.len().max(1) as f64).sqrt()
}

/// Points on the floor in the shadow of each caster, world space, metres. They assign pixels to
/// shadows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlaces(pub Vec<Vec<Vec3>>);

impl ShadowPlaces {
    /// Returns the index of the shadow whose place is nearest to a point.
    fn nearest(&self, p: Vec3) -> Option<usize> {
        let places = self
            .0
            .iter()
            .enumerate()
            .flat_map(|(i, places)| places.iter().map(move |q| (i, p.distance(*q))));
        places.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// Returns the ratio of each shadow's penumbra width to truth's; `None` if truth has no
    /// penumbra.
    ///
    /// Pixels on the floor (at the lowest place's height, within `level` metres) belong to the
    /// nearest place.
    pub fn widths(
        &self,
        mask: &[f32],
        truth: &[f32],
        receivers: &Receivers,
        level: f32,
        counts: impl Fn(usize) -> bool,
    ) -> Vec<Option<f64>> {
        let floor_height = self
            .0
            .iter()
            .flatten()
            .map(|p| p.y)
            .fold(f32::MAX, f32::min);
        let mut mask_sums = vec![0.0_f64; self.0.len()];
        let mut truth_sums = vec![0.0_f64; self.0.len()];
        for i in (0..mask.len()).filter(|&i| counts(i) && receivers.receives[i]) {
            let p = receivers.position(i);
            if (p.y - floor_height).abs() > level {
                continue;
            }
            let Some(shadow) = self.nearest(p) else {
                continue;
            };
            // The sum of v (1 - v) is proportional to the width: see the module.
            mask_sums[shadow] += f64::from(mask[i] * (1.0 - mask[i]));
            truth_sums[shadow] += f64::from(truth[i] * (1.0 - truth[i]));
        }
        mask_sums
            .into_iter()
            .zip(truth_sums)
            .map(|(mask_sum, truth_sum)| (truth_sum > 0.0).then(|| mask_sum / truth_sum))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// Returns two edges along x, at 100 and at 300 of 400 pixels, with these widths.
    fn two_edges(widths: [f32; 2]) -> Vec<f32> {
        let ramp = |x: f32, w: f32| (0.5 + x / w).clamp(0.0, 1.0);
        (0..400)
            .map(|i| i as f32 + 0.5)
            .map(|x| {
                if x < 200.0 {
                    ramp(x - 100.0, widths[0])
                } else {
                    ramp(300.0 - x, widths[1])
                }
            })
            .collect()
    }

    #[test]
    fn widths_are_distinguished_and_relative() {
        let mut receivers = Receivers::empty(UVec2::new(400, 1));
        receivers.x = (0..400).map(|i| i as f32).collect();
        receivers.receives = vec![true; 400];
        let shadows = ShadowPlaces(vec![vec![Vec3::X * 100.0], vec![Vec3::X * 300.0]]);
        let truth = two_edges([20.0, 40.0]);
        for widths in [[20.0, 40.0], [10.0, 80.0], [0.001, 20.0]] {
            let found = shadows.widths(&two_edges(widths), &truth, &receivers, 0.1, |_| true);
            for ((found, w), t) in found.into_iter().zip(widths).zip([20.0, 40.0]) {
                let expected = f64::from(w / t);
                assert!(
                    found.is_some_and(|f| (f - expected).abs() < 0.01),
                    "{widths:?}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn sixteen_rays_have_a_quarter_of_one_rays_noise() {
        let truth = two_edges([20.0, 40.0]);
        let [one, sixteen] = [1, 16].map(|rays| ray_noise(&truth, rays, |_| true));
        assert!(
            (one / sixteen - 4.0).abs() < 1e-9 && one > 0.3,
            "{one} {sixteen}"
        );
        assert_eq!(rmse(&truth, &truth, |_| true), 0.0);
        let off: Vec<f32> = truth.iter().map(|v| v * 0.5 + 0.25).collect();
        assert!(rmse(&off, &truth, |_| true) > 0.1);
        assert_eq!(rmse(&[0.0], &[1.0], |_| true), 0.0);
    }
}
