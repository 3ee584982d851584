//! c4 to c5: straight edges and a corner under area lights.
//!
//! The light is at height H = 4, the caster is a half plane x < e at height h. Seen from the floor
//! at x, the edge cuts the light at `(e - x (1 - h / H)) H / h`. Visibility is the fraction of the
//! light on one side of that line.

use super::{SIZE, floor, on_floor, sheet};
use crate::{ClosedForm, Sample, stage::Stage};
use umbrage_core::glam::Vec3;
use umbrage_core::{Light, Scene};

/// Tolerance for 1,024 stratified samples, whose standard error is below .003 in a penumbra.
const TOLERANCE: f32 = 0.005;
/// Extent of the half plane. It hides everything beyond the edge from the light.
const FAR: f32 = 8.0;
const LAMP: Vec3 = Vec3::new(0.0, 4.0, 0.0);

fn square_lamp() -> Light {
    Light::Rect {
        center: LAMP,
        half_u: Vec3::new(0.5, 0.0, 0.0),
        half_v: Vec3::new(0.0, 0.0, 0.5),
    }
}

fn under_edge(name: &str, light: Light, height: f32, edge: f32) -> Scene {
    Stage::new(name)
        .put(floor(4.0))
        .put(sheet([-FAR, edge], [-FAR, FAR], height))
        .light(light)
        .shoot([3.5, 2.6, 2.0], [0.3, 0.0, 0.0], 36.0, SIZE)
}

/// Points at z = 0 as (x, visibility).
fn along_x(points: &[(f32, f32)]) -> ClosedForm {
    ClosedForm {
        samples: points.iter().map(|&(x, v)| on_floor(x, 0.0, v)).collect(),
        tolerance: TOLERANCE,
    }
}

/// Points at z = 0 as (x, visibility, visibility weighted by irradiance).
fn weighted_form(points: &[(f32, f32, f32)]) -> ClosedForm {
    let mut samples = Vec::new();
    for &(x, visibility, weighted) in points {
        samples.push(Sample {
            weighted: Some(weighted),
            ..on_floor(x, 0.0, visibility)
        });
    }
    ClosedForm {
        samples,
        tolerance: TOLERANCE,
    }
}

pub(crate) fn edge() -> Scene {
    under_edge("c4-edge-square", square_lamp(), 2.0, 0.0)
}

/// Visibility is x + .5, clamped. Weighted: the ratio of Lambert's polygon irradiances.
pub(crate) fn edge_samples() -> ClosedForm {
    let mut out = weighted_form(&[
        (-0.4, 0.1, 0.094310),
        (-0.25, 0.25, 0.242422),
        (0.0, 0.5, 0.5),
        (0.25, 0.75, 0.757578),
        (0.4, 0.9, 0.905690),
    ]);
    out.samples
        .extend([on_floor(-0.5, 0.0, 0.0), on_floor(0.5, 0.0, 1.0)]);
    out
}

pub(crate) fn low_edge() -> Scene {
    under_edge("c4b-low-edge-square", square_lamp(), 0.5, 0.1)
}

/// Visibility is a ramp from x = .042857 to .185714.
pub(crate) fn low_edge_samples() -> ClosedForm {
    weighted_form(&[
        (0.078571, 0.25, 0.249873),
        (0.114286, 0.5, 0.503505),
        (0.15, 0.75, 0.755339),
    ])
}

pub(crate) fn turned_edge() -> Scene {
    let half = 0.5 * std::f32::consts::FRAC_1_SQRT_2;
    let light = Light::Rect {
        center: LAMP,
        half_u: Vec3::new(half, 0.0, half),
        half_v: Vec3::new(-half, 0.0, half),
    };
    under_edge("c4c-edge-turned-square", light, 2.0, 0.0)
}

/// The edge's position is t half diagonals of the light: 1 - (1 + t)^2 / 2 for t < 0, else (1 -
/// t)^2 / 2.
pub(crate) fn turned_edge_samples() -> ClosedForm {
    along_x(&[
        (-0.565685, 0.02),
        (-0.353553, 0.125),
        (0.0, 0.5),
        (0.353553, 0.875),
    ])
}

pub(crate) fn disc_edge() -> Scene {
    under_edge(
        "c4d-edge-disc",
        Light::Disc {
            center: LAMP,
            normal: Vec3::NEG_Y,
            radius: 0.5,
        },
        2.0,
        0.0,
    )
}

/// The edge's position is t radii of the light: (acos t - t sqrt(1 - t^2)) / pi.
pub(crate) fn disc_edge_samples() -> ClosedForm {
    along_x(&[
        (-0.4, 0.052044),
        (-0.25, 0.195501),
        (0.0, 0.5),
        (0.25, 0.804499),
    ])
}

pub(crate) fn corner() -> Scene {
    Stage::new("c5-corner-square")
        .put(floor(4.0))
        .put(sheet([-FAR, 0.0], [-FAR, 0.0], 2.0))
        .light(square_lamp())
        .shoot([2.5, 2.6, 2.5], [0.1, 0.0, 0.1], 36.0, SIZE)
}

/// For r, the ramp of a straight edge: 1 - (1 - r(x)) (1 - r(z)).
pub(crate) fn corner_samples() -> ClosedForm {
    let points = [
        (0.0, 0.0, 0.75),
        (-0.25, -0.25, 0.4375),
        (0.25, -0.25, 0.8125),
        (0.25, 0.25, 0.9375),
        (-0.4, 0.1, 0.64),
    ];
    ClosedForm {
        samples: points.iter().map(|&(x, z, v)| on_floor(x, z, v)).collect(),
        tolerance: TOLERANCE,
    }
}
