//! Scenes whose shadows follow from a formula. The samples were also checked against an independent
//! ray tracer.

pub(crate) mod area;
pub(crate) mod card;
pub(crate) mod everywhere;
pub(crate) mod point_like;
pub(crate) mod room;
pub(crate) mod slits;

#[cfg(test)]
mod tests;

use crate::{
    ClosedForm, Sample,
    primitives::{grid, quad},
};
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

const SIZE: [u32; 2] = [320, 240];

/// A point on the floor with this visibility.
fn on_floor(x: f32, z: f32, visibility: f32) -> Sample {
    Sample {
        point: Vec3::new(x, 0.0, z),
        normal: Vec3::Y,
        visibility,
        weighted: None,
    }
}

/// Points (x, z, visibility) on the floor under a light without extent, where results are exact.
fn exact(points: &[(f32, f32, f32)]) -> ClosedForm {
    ClosedForm {
        samples: points.iter().map(|&(x, z, v)| on_floor(x, z, v)).collect(),
        tolerance: 0.0,
    }
}

pub(crate) fn floor(half: f32) -> Mesh {
    Mesh {
        name: "floor".to_owned(),
        ..grid([half, half], [1, 1], |_, _| 0.0)
    }
}

/// A horizontal sheet without thickness.
pub(crate) fn sheet(x: [f32; 2], z: [f32; 2], height: f32) -> Mesh {
    let at = |x, z| Vec3::new(x, height, z);
    quad([
        at(x[0], z[0]),
        at(x[0], z[1]),
        at(x[1], z[1]),
        at(x[1], z[0]),
    ])
}
