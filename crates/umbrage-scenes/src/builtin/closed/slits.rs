//! c6 to c6c: narrow slits, and a closed seam.

use super::{SIZE, exact, floor, sheet};
use crate::{
    ClosedForm,
    primitives::block,
    stage::{Stage, sun},
};
use umbrage_core::{Mesh, Scene};

fn scene_with_slit(name: &str, sides: [Mesh; 2]) -> Scene {
    let [left, right] = sides;
    Stage::new(name)
        .put(floor(4.0))
        .put(left)
        .put(right)
        .light(sun(1.0, -2.0, 0.0))
        .shoot([0.9, 0.75, 2.0], [0.5, 0.0, 0.0], 40.0, SIZE)
}

pub(crate) fn slit() -> Scene {
    let sides = [
        sheet([-3.0, -0.01], [-3.0, 3.0], 1.0),
        sheet([0.01, 3.0], [-3.0, 3.0], 1.0),
    ];
    scene_with_slit("c6-slit", sides)
}

/// Lit where .49 < x < .51.
pub(crate) fn slit_samples() -> ClosedForm {
    exact(&[
        (0.489, 0.0, 0.0),
        (0.491, 0.0, 1.0),
        (0.509, 0.0, 1.0),
        (0.511, 0.0, 0.0),
    ])
}

pub(crate) fn thick_slit() -> Scene {
    let slab = |x: [f32; 2]| block([x[0], 1.0, -3.0], [x[1], 1.03, 3.0]);
    scene_with_slit("c6b-thick-slit", [slab([-3.0, -0.01]), slab([0.01, 3.0])])
}

/// The thickness of the slabs hides half of the gap: lit where .505 < x < .51.
pub(crate) fn thick_slit_samples() -> ClosedForm {
    exact(&[
        (0.504, 0.0, 0.0),
        (0.506, 0.0, 1.0),
        (0.509, 0.0, 1.0),
        (0.511, 0.0, 0.0),
    ])
}

pub(crate) fn seam() -> Scene {
    scene_with_slit(
        "c6c-seam",
        [
            sheet([-3.0, 0.0], [-3.0, 3.0], 1.0),
            sheet([0.0, 3.0], [-3.0, 3.0], 1.0),
        ],
    )
}

/// Two sheets share an edge but no vertices: everything below is dark.
pub(crate) fn seam_samples() -> ClosedForm {
    // Sample densely around x = .5, where light through the seam would fall. Steps of 2^-10 hit it
    // exactly.
    let xs = (-64..=64).map(|i| 0.5 + i as f32 / 1024.0);
    let points: Vec<_> = xs
        .flat_map(|x| (-8..=8).map(move |k| (x, k as f32 / 16.0, 0.0)))
        .collect();
    exact(&points)
}
