//! Tests of the samples against the formulas, and against rays through the scenes.

use super::*;
use crate::{Kind, SceneEntry, all, find};
use umbrage_core::glam::DVec3;
use umbrage_core::{Geometry, Light, Scene};

fn samples(name: &str) -> Vec<Sample> {
    (find(name).unwrap().closed_form.unwrap())().samples
}

/// Tolerance of sample positions and visibilities, which are written with up to six digits.
const DIGITS: f64 = 2e-6;

fn holds(name: &str, formula: impl Fn(f64, f64) -> f64) {
    for s in samples(name) {
        let v = formula(f64::from(s.point.x), f64::from(s.point.z));
        assert!(
            (v - f64::from(s.visibility)).abs() < DIGITS,
            "{name}: {v} at {s:?}"
        );
    }
}

fn lit_figure(is_lit: bool) -> f64 {
    f64::from(u8::from(is_lit))
}

#[test]
fn ideal_lights_follow_their_formulas() {
    let hexagon = [
        (-1.0, -1.0),
        (1.0, -1.0),
        (2.0, -0.5),
        (2.0, 1.5),
        (0.0, 1.5),
        (-1.0, 1.0),
    ];
    holds("c1-box-sun", |x, z| {
        let left_of = |i: usize| {
            let (ax, az) = hexagon[i];
            let (bx, bz) = hexagon[(i + 1) % 6];
            (bx - ax) * (z - az) - (bz - az) * (x - ax) > 0.0
        };
        lit_figure(!(0..6).all(left_of))
    });
    holds("c2-sphere-sun", |x, z| {
        lit_figure(((x - 12.0_f64.sqrt()) / 2.0).powi(2) + z * z > 1.0)
    });
    holds("c3-sphere-bulb", |x, z| {
        lit_figure((x + 8.0).powi(2) < 4.75 * (x * x + z * z + 16.0))
    });
    holds("c3b-sphere-level-bulb", |x, z| {
        lit_figure(x * x / 32.0 - z * z / 4.0 < 1.0)
    });
    holds("c6-slit", |x, _| lit_figure(x > 0.49 && x < 0.51));
    holds("c6b-thick-slit", |x, _| lit_figure(x > 0.505 && x < 0.51));
    holds("c10-chequered-card", |x, z| {
        // Position relative to the shadow's centre, in squares.
        let place = [(x - 0.5) / 0.4, z / 0.4];
        let is_outside = place.iter().any(|t| t.abs() > 3.0);
        let parity = place[0].floor() + place[1].floor();
        lit_figure(is_outside || parity.rem_euclid(2.0) == 0.0)
    });
}

/// The ray from the light passes within a sphere's radius of its centre if and only if the angle to
/// the centre is less than half the angle that the sphere subtends.
#[test]
fn spheres_around_a_bulb_follow_their_cones() {
    let in_cone = |x: f64, z: f64, (center, radius): (Vec3, f32)| {
        let to_point = DVec3::new(x, 0.0, z) - room::BULB.as_dvec3();
        let to_center = (center - room::BULB).as_dvec3();
        to_point.angle_between(to_center) < (f64::from(radius) / to_center.length()).asin()
    };
    holds("c3-room", |x, z| {
        lit_figure(!room::SPHERES.iter().any(|&sphere| in_cone(x, z, sphere)))
    });
}

/// Position at which the edge cuts the light, from the floor at x: height h, edge at e, light at 4.
fn edge_on_lamp(x: f64, h: f64, e: f64) -> f64 {
    (e - x * (1.0 - h / 4.0)) * 4.0 / h
}

/// Fraction of a square light of half side .5 beyond the edge.
fn ramp(x: f64) -> f64 {
    (0.5 - edge_on_lamp(x, 2.0, 0.0)).clamp(0.0, 1.0)
}

#[test]
fn lamps_follow_their_formulas() {
    holds("c4-edge-square", |x, _| ramp(x));
    holds("c4b-low-edge-square", |x, _| {
        // Positions in the list are rounded, and the ramp is seven times steeper than the digits of
        // the list.
        let v = (0.5 - edge_on_lamp(x, 0.5, 0.1)).clamp(0.0, 1.0);
        (v * 4e4).round() / 4e4
    });
    holds("c4c-edge-turned-square", |x, _| {
        let t = (edge_on_lamp(x, 2.0, 0.0) * 2.0_f64.sqrt()).clamp(-1.0, 1.0);
        if t < 0.0 {
            1.0 - (1.0 + t).powi(2) / 2.0
        } else {
            (1.0 - t).powi(2) / 2.0
        }
    });
    holds("c4d-edge-disc", |x, _| {
        let t = (edge_on_lamp(x, 2.0, 0.0) / 0.5).clamp(-1.0, 1.0);
        (t.acos() - t * (1.0 - t * t).sqrt()) / std::f64::consts::PI
    });
    holds("c5-corner-square", |x, z| {
        1.0 - (1.0 - ramp(x)) * (1.0 - ramp(z))
    });
}

/// Irradiance of a floor point under a polygon of uniform radiance pi (Lambert 1760): the sum over
/// its edges of the angle they span times the slope of the plane through them.
fn lambert(from: f64, to: f64, x: f64) -> f64 {
    let corners = [(from, -0.5), (from, 0.5), (to, 0.5), (to, -0.5)]
        .map(|(lx, lz)| DVec3::new(lx - x, 4.0, lz));
    let edge = |i: usize| {
        let a = corners[i].normalize();
        let b = corners[(i + 1) % 4].normalize();
        a.dot(b).acos() * a.cross(b).normalize().y
    };
    (0..4).map(edge).sum::<f64>().abs() / 2.0
}

#[test]
fn weighted_visibility_is_a_ratio_of_irradiances() {
    for (name, h, e) in [
        ("c4-edge-square", 2.0, 0.0),
        ("c4b-low-edge-square", 0.5, 0.1),
    ] {
        for s in samples(name) {
            let Some(weighted) = s.weighted else { continue };
            let x = f64::from(s.point.x);
            let ratio = lambert(edge_on_lamp(x, h, e), 0.5, x) / lambert(-0.5, 0.5, x);
            // The tolerance covers six digits, and the rounded positions on the steep ramp of the
            // low edge.
            assert!(
                (ratio - f64::from(weighted)).abs() < 1e-5,
                "{name}: {ratio} at {s:?}"
            );
        }
    }
}

fn cases() -> impl Iterator<Item = (&'static SceneEntry, Scene, ClosedForm)> {
    let closed = all().iter().filter(|entry| entry.kind == Kind::ClosedForm);
    closed.map(|entry| (entry, (entry.build)(), (entry.closed_form.unwrap())()))
}

/// Returns the visible fraction of the light, from rays to a uniform grid on it.
fn traced_visibility(geometry: &Geometry, light: &Light, s: &Sample, triangle: u32) -> f32 {
    const SIDE: i32 = 96;
    // Offset the origin by far less than any distance in these scenes.
    let origin = s.point + s.normal * 1e-5;
    let sees = |d: Vec3| d.dot(s.normal) > 0.0 && !geometry.bvh().is_occluded(origin, d, triangle);
    let grid = (0..SIDE * SIDE)
        .map(|i| [i % SIDE, i / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0));
    let fraction = |points: Vec<Vec3>| {
        let seen = points.iter().filter(|p| sees(**p - origin)).count();
        seen as f32 / points.len() as f32
    };
    match *light {
        Light::Directional { direction, .. } => {
            f32::from(u8::from(sees(-direction.normalize() * 1e3)))
        }
        Light::Point { position, .. } => fraction(vec![position]),
        Light::Rect {
            center,
            half_u,
            half_v,
        } => fraction(
            grid.map(|[u, v]| center + half_u * u + half_v * v)
                .collect(),
        ),
        Light::Disc { center, radius, .. } => {
            let inside = grid.filter(|[u, v]| u * u + v * v < 1.0);
            fraction(
                inside
                    .map(|[u, v]| center + Vec3::new(u, 0.0, v) * radius)
                    .collect(),
            )
        }
        Light::Spot { .. } => f32::NAN,
    }
}

/// Returns the largest difference between samples and rays.
fn worst(geometry: &Geometry, light: &Light, samples: &[Sample]) -> f32 {
    let error = |s: &Sample| {
        let triangle = s
            .triangle(geometry)
            .unwrap_or_else(|| panic!("no triangle at {s:?}"));
        (traced_visibility(geometry, light, s, triangle) - s.visibility).abs()
    };
    samples.iter().map(error).fold(0.0, f32::max)
}

/// Error allowed for the grid of rays: one column. The tolerance of the samples is added to it.
const GRID: f32 = 1.0 / 96.0;

#[test]
fn rays_agree_with_the_samples() {
    for (entry, scene, closed) in cases() {
        let geometry = Geometry::bake(&scene).unwrap();
        let light = scene.lights[0];
        let allowed = if light.is_ideal() { 0.0 } else { GRID };
        let found = worst(&geometry, &light, &closed.samples);
        assert!(found <= allowed, "{}: {found}", entry.name);
        let mut spoilt = closed.samples[0];
        spoilt.visibility += if spoilt.visibility < 0.5 { 0.05 } else { -0.05 };
        assert!(
            worst(&geometry, &light, &[spoilt]) > allowed,
            "{}: a wrong formula was not detected",
            entry.name
        );
    }
}

/// Reports whether a point is unoccluded in the camera's image.
fn is_seen(geometry: &Geometry, scene: &Scene, s: &Sample) -> bool {
    let camera = &scene.cameras[0];
    let clip = camera.space().clip_from_world() * s.point.extend(1.0);
    let inside = clip.w > 0.0 && clip.truncate().abs().max_element() < clip.w && clip.z > 0.0;
    let (eye, Some(triangle)) = (camera.eye(), s.triangle(geometry)) else {
        return false;
    };
    inside
        && (eye - s.point).dot(s.normal) > 0.0
        && !geometry
            .bvh()
            .is_occluded(s.point + s.normal * 1e-4, eye - s.point, triangle)
}

#[test]
fn cameras_see_the_samples() {
    for (entry, scene, closed) in cases() {
        let geometry = Geometry::bake(&scene).unwrap();
        let seen = closed
            .samples
            .iter()
            .filter(|s| is_seen(&geometry, &scene, s))
            .count();
        let least = match entry.name {
            // Contact is sampled on two sides of the box, one of which is always hidden.
            "c1-box-sun" => closed.samples.len() - 1,
            // A solid, or a room around the camera, hides most samples.
            "c7-closed-room" | "c8-faceted-sphere" => closed.samples.len() / 4,
            _ => closed.samples.len(),
        };
        assert!(
            seen >= least,
            "{}: {seen} of {}",
            entry.name,
            closed.samples.len()
        );
        let hidden = Sample {
            point: closed.samples[0].point - Vec3::Y * 50.0,
            ..closed.samples[0]
        };
        assert!(!is_seen(&geometry, &scene, &hidden));
    }
}
