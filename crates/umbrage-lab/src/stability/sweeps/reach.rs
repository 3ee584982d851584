//! How techniques fare as the light sinks, the scene grows, moves away, or the map shrinks: RMSE, beside that of a perfect
//! map of the same size.

use super::{Curve, Sweep, moved, not_played, play, scaled, under_sun};
use crate::{
    LabError,
    compare::Backends,
    stability::{CaseTruth, Measure, StabilityOptions, all_backends, guard::NoMask, settings},
};
use glam::Vec3;
use umbrage_core::{Fit, Scene};

/// What is turned.
#[derive(Debug)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    title: &'static str,
    scene: &'static str,
    x: &'static str,
    values: &'static [f64],
    turn: fn(&Scene, f64) -> Scene,
    /// Whether the value is the maps' side instead.
    is_map_size: bool,
}

const fn kind(name: &'static str, scene: &'static str, values: &'static [f64]) -> Kind {
    Kind {
        name,
        title: "",
        scene,
        x: "",
        values,
        turn: same,
        is_map_size: false,
    }
}

fn same(scene: &Scene, _: f64) -> Scene {
    scene.clone()
}

fn scale(scene: &Scene, by: f64) -> Scene {
    scaled(scene, by as f32)
}

/// Not along one axis alone, nor along the sun's way.
fn away(scene: &Scene, distance: f64) -> Scene {
    moved(scene, Vec3::new(0.8, 0.0, -0.6) * distance as f32)
}

#[rustfmt::skip]
pub(super) const ALL: &[Kind] = &[
    Kind { title: "light angle: a row of spheres", x: "sun above the horizon, degrees", turn: under_sun,
           ..kind("angle", "low-sun-5", &[0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0]) },
    Kind { title: "scale: cubes", x: "scale", turn: scale,
           ..kind("scale", "cubes", &[1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3, 1e4]) },
    Kind { title: "distance from the origin: cubes", x: "distance, m", turn: away,
           ..kind("distance", "cubes", &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6]) },
    Kind { title: "map size: cubes", x: "map side, texels", is_map_size: true,
           ..kind("map-size", "cubes", &[64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0, 4096.0]) },
];

/// The techniques drawn: few enough to tell their curves apart.
const TECHNIQUES: [&str; 4] = ["hard", "pcf", "second_depth", "volumes"];

pub(super) fn sweep(
    kind: &Kind,
    options: &StabilityOptions,
    backends: &mut Backends,
) -> Result<Sweep, LabError> {
    let entry = umbrage_scenes::find(kind.scene);
    let scene = entry.map(|e| (e.build)()).unwrap_or_default();
    let mut curves = vec![Curve {
        label: "perfect map".to_owned(),
        points: Vec::new(),
    }];
    let mut disagreeing = None;
    for (place, &value) in kind.values.iter().enumerate() {
        let size = if kind.is_map_size {
            value as u32
        } else {
            options.map_size
        };
        let variant = (kind.turn)(&scene, value);
        let (camera, lights) = (
            variant.cameras[0].resized(options.size),
            variant.lights[..1].to_vec(),
        );
        let case_truth = CaseTruth::new(variant, camera, lights, size, &options.truth)?;
        let error_of_ideal = Measure::Rmse.figure(&case_truth, &case_truth.ideal);
        add(&mut curves[0], value, error_of_ideal);
        let wanted = TECHNIQUES.map(str::to_owned);
        for (i, technique) in settings(&options.registry, &wanted, size, Fit::Tight)
            .iter()
            .enumerate()
        {
            if curves.len() < i + 2 {
                let label = format!("{} ({})", technique.name(), technique.settings());
                // The side is on the axis, or in the title of none.
                curves.push(Curve {
                    label: label.replace(&format!("{size}, "), ""),
                    points: Vec::new(),
                });
            }
            match play(
                &case_truth,
                &**technique,
                backends,
                place,
                kind.values.len(),
            ) {
                Ok(played) => {
                    let error = Measure::Rmse.figure(&case_truth, &played.mask);
                    add(&mut curves[i + 1], value, error);
                    disagreeing = all_backends::sum(disagreeing, played.disagreeing);
                }
                Err(NoMask::Unsupported(_)) => {}
                Err(NoMask::Fault(what)) => {
                    return Err(not_played(&case_truth, &**technique, &what));
                }
            }
        }
    }
    Ok(Sweep {
        name: kind.name.to_owned(),
        title: kind.title.to_owned(),
        x: kind.x.to_owned(),
        y: "RMSE".to_owned(),
        curves,
        best: None,
        limit: None,
        disagreeing,
    })
}

fn add(curve: &mut Curve, x: f64, y: f64) {
    curve.points.push([x, y]);
}
