//! Penumbrae: how wrong within, and how wide.
//!
//! Over a penumbra that runs linearly from 0 to 1 over a width w, the integral of v (1 - v) across it is w / 6; so the sum
//! of v (1 - v) over pixels, each weighted alike in mask and truth, tells the ratio of widths without finding an edge.
//! Dithering with n equal taps takes 1/n off the sum.

use glam::Vec3;
use umbrage_core::{Receivers, metrics::is_penumbra};

/// RMSE over the pixels that truth has in penumbra; 0 without any.
pub fn rmse(mask: &[f32], truth: &[f32], counts: impl Fn(usize) -> bool) -> f64 {
    root_mean(mask.len(), truth, counts, |i| {
        (f64::from(mask[i]) - f64::from(truth[i])).powi(2)
    })
}

/// The RMSE that `rays` independent rays a pixel would have over the same pixels: binomial, v (1 - v) / n each.
pub fn ray_noise(truth: &[f32], rays: u32, counts: impl Fn(usize) -> bool) -> f64 {
    root_mean(truth.len(), truth, counts, |i| {
        f64::from(truth[i]) * f64::from(1.0 - truth[i]) / f64::from(rays)
    })
}

fn root_mean(
    len: usize,
    truth: &[f32],
    counts: impl Fn(usize) -> bool,
    square: impl Fn(usize) -> f64,
) -> f64 {
    let here = || (0..len).filter(|&i| counts(i) && is_penumbra(truth[i]));
    (here().map(square).sum::<f64>() / here().count().max(1) as f64).sqrt()
}

/// Places about which shadows are told apart: each of a shadow's places, on the ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shadows(pub Vec<Vec<Vec3>>);

impl Shadows {
    /// The shadow whose place is nearest to a point.
    fn of(&self, p: Vec3) -> Option<usize> {
        let places = self
            .0
            .iter()
            .enumerate()
            .flat_map(|(i, places)| places.iter().map(move |q| (i, p.distance(*q))));
        places.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// For each shadow its penumbra's width over truth's, 1 if right: pixels on the ground (at the places' height, within
    /// `level` metres) belong to the nearest place. None where truth has no penumbra.
    pub fn widths(
        &self,
        mask: &[f32],
        truth: &[f32],
        receivers: &Receivers,
        level: f32,
        counts: impl Fn(usize) -> bool,
    ) -> Vec<Option<f64>> {
        let ground = self
            .0
            .iter()
            .flatten()
            .map(|p| p.y)
            .fold(f32::MAX, f32::min);
        let mut sums = vec![[0.0_f64; 2]; self.0.len()];
        for i in (0..mask.len()).filter(|&i| counts(i) && receivers.receives[i]) {
            let p = receivers.position(i);
            if (p.y - ground).abs() > level {
                continue;
            }
            let Some(shadow) = self.of(p) else { continue };
            for (sum, v) in sums[shadow].iter_mut().zip([mask[i], truth[i]]) {
                *sum += f64::from(v * (1.0 - v));
            }
        }
        sums.into_iter()
            .map(|[mask, truth]| (truth > 0.0).then(|| mask / truth))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// Two edges along x, at 100 and at 300 of 400 pixels, with these widths.
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
    fn widths_are_told_apart_and_relative() {
        let mut receivers = Receivers::empty(UVec2::new(400, 1));
        receivers.x = (0..400).map(|i| i as f32).collect();
        receivers.receives = vec![true; 400];
        let shadows = Shadows(vec![vec![Vec3::X * 100.0], vec![Vec3::X * 300.0]]);
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
