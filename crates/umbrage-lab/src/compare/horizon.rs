//! The share of a light above a receiver's horizon, in 64 bits: the correct result of kernels that
//! account for the horizon.

use glam::{DVec2, DVec3, Vec3, Vec4};
use std::f64::consts::PI;
use umbrage_core::light_sample::{LightSampler, kind};

/// Returns the share of the light above the tangent plane at `p` with unit normal `n`, 0..=1.
///
/// The result is the interval of correct values if heights above the plane have an error of at most
/// `margin`, metres (for directions: this sine).
pub(super) fn share(light: &LightSampler, p: Vec3, n: Vec3, margin: f64) -> [f64; 2] {
    let n = n.as_dvec3();
    let to_center = light.center.truncate().as_dvec3() - p.as_dvec3();
    let height = n.dot(to_center);
    match light.shape.x {
        kind::RECT => {
            let axes = DVec2::new(height_of(light.half_u, n), height_of(light.half_v, n));
            [square(height - margin, axes), square(height + margin, axes)]
        }
        kind::DISC => {
            let axes = DVec2::new(height_of(light.half_u, n), height_of(light.half_v, n));
            let rim = axes.length();
            [disc(height - margin, rim), disc(height + margin, rim)]
        }
        kind::BALL => {
            let rim = f64::from(light.half_u.w) * rim_of_facing_disc(n, to_center);
            [disc(height - margin, rim), disc(height + margin, rim)]
        }
        _ => {
            let to_light = light.center.truncate().as_dvec3();
            let height = n.dot(to_light);
            let cosine = 1.0 - f64::from(light.half_u.w);
            let tangent = (1.0 - cosine * cosine).sqrt() / cosine;
            let rim = tangent * rim_of_facing_disc(n, to_light);
            // The cap of directions may count as flat. On a flat disc of radius 1, a point at r
            // weighs more than on the cap by 3/2 (r^2 - 1/2) of the tangent's square. Over a
            // segment this sums to at most 0.052 of the square.
            let curved = tangent * tangent / 16.0;
            [
                disc(height - margin, rim) - curved,
                disc(height + margin, rim) + curved,
            ]
        }
    }
}

/// Returns the height of a half axis above the tangent plane with unit normal `n`.
fn height_of(half_axis: Vec4, n: DVec3) -> f64 {
    n.dot(half_axis.truncate().as_dvec3())
}

/// Returns the height of the rim above the centre, for a disc of radius 1 that faces the receiver.
/// It is the sine of the angle between the normal and the direction to the light.
fn rim_of_facing_disc(n: DVec3, to_light: DVec3) -> f64 {
    let cosine = n.dot(to_light.normalize_or(n));
    (1.0 - cosine.powi(2)).max(0.0).sqrt()
}

/// Returns the share of a disc above the plane, which cuts off a circular segment. The centre is
/// `height` above it, the highest point `rim` higher.
fn disc(height: f64, rim: f64) -> f64 {
    if height.abs() >= rim {
        return f64::from(u8::from(height >= 0.0));
    }
    let t = height / rim;
    1.0 - (t.acos() - t * (1.0 - t * t).sqrt()) / PI
}

/// Returns the share of the square -1..1 in which `height + axes.x x + axes.y y` is positive.
///
/// For each y it is a length, which is linear in y where it is neither 0 nor 1. The mean over y
/// follows from its antiderivative.
fn square(height: f64, axes: DVec2) -> f64 {
    let steeper = axes.abs().max_element();
    let flatter = axes.abs().min_element();
    if height.abs() >= steeper + flatter {
        return f64::from(u8::from(height >= 0.0));
    }
    // The positive share of the lines at both ends of the flatter axis, before it is clamped to
    // 0..=1.
    let first = 0.5 * (1.0 + (height - flatter) / steeper);
    let last = 0.5 * (1.0 + (height + flatter) / steeper);
    if last - first < 1e-9 {
        return first.clamp(0.0, 1.0);
    }
    (clamped_integral(last) - clamped_integral(first)) / (last - first)
}

/// Returns the integral of `t` clamped to 0..=1 from 0 to `length`.
fn clamped_integral(length: f64) -> f64 {
    if length <= 0.0 {
        0.0
    } else if length < 1.0 {
        0.5 * length * length
    } else {
        length - 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{
        Light,
        light_sample::{segment, unit_square},
    };

    /// Points of the light as used by truth. 4,096 of them are one in each of 64 x 64 cells, of
    /// which a line crosses at most 127.
    #[test]
    fn shares_are_those_of_truths_points() {
        let (position, direction) = (Vec3::new(0.4, 3.0, -0.7), Vec3::new(0.3, -0.2, 0.4));
        let lights = [
            Light::Rect {
                center: position,
                half_u: Vec3::new(1.0, 0.3, 0.0),
                half_v: Vec3::new(-0.1, 0.5, 0.9),
            },
            Light::Disc {
                center: position,
                normal: direction,
                radius: 0.9,
            },
            Light::Point {
                position,
                radius: 0.8,
            },
            Light::Directional {
                direction,
                angular_diameter: 0.4,
            },
        ];
        for light in lights.iter().map(LightSampler::new) {
            let mut cut = 0;
            for i in 0..200 {
                let turn = f64::from(i) * 0.9;
                let up = f64::from(i % 20) * 0.1 - 1.0;
                let n = DVec3::new(turn.cos(), up, turn.sin()).normalize().as_vec3();
                let p = Vec3::new((turn * 0.3).sin() as f32, 2.0 + up as f32, -0.5);
                let above = |i: &u32| n.dot(segment(&light, p, unit_square(*i, 0), 1.0)) > 0.0;
                let counted = (0..4096).filter(above).count() as f64 / 4096.0;
                let [least, most] = share(&light, p, n, 0.0);
                let slack = 127.0 / 4096.0;
                assert!(
                    (least - slack..=most + slack).contains(&counted),
                    "{light:?} {p} {n}: {counted}, {least}"
                );
                // Errors of crossed cells mostly cancel out.
                cut += usize::from(
                    counted > 0.0
                        && counted < 1.0
                        && ((least + most) / 2.0 - counted).abs() < 0.005,
                );
            }
            assert!(
                cut > 20,
                "{light:?}: only {cut} horizons cut it where they should"
            );
        }
    }
}
