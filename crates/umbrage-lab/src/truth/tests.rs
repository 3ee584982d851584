//! Truth against formulas, at every scale.

use super::*;
use glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Instance, Mesh, NO_TRIANGLE, Scene};

const QUICK: TruthOptions =
    TruthOptions { samples: 256, penumbra_factor: 4, probe_samples: 16, ambiguous_change: 0.25 };

/// Every closed form, with the point's triangle known and unknown.
#[test]
fn closed_forms_hold() {
    let mut checked = 0;
    for entry in umbrage_scenes::all() {
        let Some(closed_form) = entry.closed_form else { continue };
        let (scene, closed_form) = ((entry.build)(), closed_form());
        let geometry = Geometry::bake(&scene).expect("built in");
        let point = |p: Vec3, n: Vec3| Point::new(p, n, &geometry);
        let known = closed_form
            .samples
            .iter()
            .map(|s| Point { triangle: s.triangle(&geometry).unwrap_or(NO_TRIANGLE), ..point(s.point, s.normal) });
        let unknown = closed_form.samples.iter().map(|s| point(s.point, s.normal));
        for points in [known.collect::<Vec<_>>(), unknown.collect()] {
            let seen = trace_points(&geometry, &scene.lights[0], &points, &TruthOptions::default()).expect("valid");
            for (seen, sample) in seen.iter().zip(&closed_form.samples) {
                let off = (seen.visibility - sample.visibility).abs();
                let at = sample.point;
                assert!(
                    off <= closed_form.tolerance,
                    "{}: {at} sees {}, not {}",
                    entry.name,
                    seen.visibility,
                    sample.visibility
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 200, "only {checked} samples: where are the scenes?");
}
