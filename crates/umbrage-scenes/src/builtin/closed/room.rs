//! c3 in a room, with two more spheres: a point light among casters whose shadows cross the seams
//! of a cube map.
//!
//! A point P is in the shadow of a sphere (centre C, radius R) if and only if its ray to the light
//! L passes the centre within R on the near side of the light:
//! `(m . (P - L))^2 > (m . m - R^2) |P - L|^2` with m = C - L.

use super::{SIZE, exact};
use crate::{
    ClosedForm,
    primitives::{icosphere, slabs_around},
    stage::{Stage, bulb},
};
use umbrage_core::Scene;
use umbrage_core::glam::Vec3;

pub(super) const BULB: Vec3 = Vec3::new(0.0, 4.0, 0.0);
/// Centres and radii: c3's sphere; one towards the seam between -x and -y; one towards the corner
/// of -x, -y and +z.
pub(super) const SPHERES: [(Vec3, f32); 3] = [
    (Vec3::new(1.0, 2.0, 0.0), 0.5),
    (Vec3::new(-1.5, 2.5, 0.0), 0.4),
    (Vec3::new(-1.2, 2.8, 1.2), 0.35),
];

pub(crate) fn room() -> Scene {
    // c3's sphere keeps its 20,480 triangles. The others have 5,120, whose outlines are within half
    // a millimetre of the spheres'.
    let spheres = SPHERES
        .iter()
        .zip([5, 4, 4])
        .map(|(&(center, radius), splits)| icosphere(center, radius, splits));
    let slabs = slabs_around(Vec3::new(-8.0, 0.0, -8.0), Vec3::new(8.0, 7.0, 8.0), 0.2);
    slabs
        .into_iter()
        .chain(spheres)
        .fold(Stage::new("c3-room"), Stage::put)
        .light(bulb(BULB.x, BULB.y, BULB.z))
        .shoot([-1.2, 6.6, -7.4], [-1.3, 0.0, 0.6], 64.0, SIZE)
}

/// Samples of c3; samples across the seam at x = -4, where the second shadow spans -5.902 to
/// -2.711; and samples along the diagonal z = -x, where the third spans 2.832 to 5.914 and the
/// corner is at 4.
pub(crate) fn room_samples() -> ClosedForm {
    let mut out = super::point_like::sphere_bulb_samples();
    let seam = [
        (-2.69, 1.0),
        (-2.73, 0.0),
        (-3.99, 0.0),
        (-4.0, 0.0),
        (-4.01, 0.0),
        (-5.88, 0.0),
        (-5.93, 1.0),
    ];
    let corner = [
        (2.81, 1.0),
        (2.86, 0.0),
        (3.99, 0.0),
        (4.0, 0.0),
        (4.01, 0.0),
        (5.88, 0.0),
        (5.95, 1.0),
    ];
    // Lit points on the seams, between the shadows and beyond them.
    let between = [
        (-4.0, -3.0, 1.0),
        (4.0, 4.0, 1.0),
        (0.0, 4.0, 1.0),
        (4.0, 0.0, 1.0),
    ];
    let points: Vec<_> = (seam.iter().map(|&(x, v)| (x, 0.0, v)))
        .chain(corner.iter().map(|&(d, v)| (-d, d, v)))
        .chain(between)
        .collect();
    out.samples.extend(exact(&points).samples);
    out
}
