//! RMSE of techniques compared with a perfect map of the same size, as the light sinks, the scene
//! grows or moves away, or the map shrinks.

use super::{
    curve::{Curve, Sweep, render_point, sweep_error},
    variants::{move_scene, scale_scene, under_sun},
};
use crate::{
    error::LabError,
    stability::{
        all_backends, case_truth::CaseTruth, guard::NoMask, measure::Measure,
        run::StabilityOptions, settings, threads::SharedBackends,
    },
};
use glam::Vec3;
use umbrage_core::{Fit, Scene, ShadowTechnique};
use umbrage_techniques::TechniquePreset;

/// A scene and the quantity that is varied in it.
#[derive(Debug)]
pub(super) struct ReachSweep {
    /// Name for files.
    pub(super) name: &'static str,
    title: &'static str,
    /// Name of a built-in scene.
    scene: &'static str,
    /// Label of the x axis, with its unit.
    x: &'static str,
    /// Values to run, increasing.
    values: &'static [f64],
    /// Returns the scene at a value.
    vary: fn(&Scene, f64) -> Scene,
    /// Whether the value is the maps' side in texels and the scene is unchanged.
    is_map_size: bool,
}

/// Returns a sweep with an unchanged scene; the list below sets the other fields.
const fn kind(name: &'static str, scene: &'static str, values: &'static [f64]) -> ReachSweep {
    ReachSweep {
        name,
        title: "",
        scene,
        x: "",
        values,
        vary: same_scene,
        is_map_size: false,
    }
}

fn same_scene(scene: &Scene, _: f64) -> Scene {
    scene.clone()
}

fn scale(scene: &Scene, by: f64) -> Scene {
    scale_scene(scene, by as f32)
}

/// Moves the scene in a direction that is neither an axis nor the sun's.
fn scene_at_distance(scene: &Scene, distance: f64) -> Scene {
    move_scene(scene, Vec3::new(0.8, 0.0, -0.6) * distance as f32)
}

/// Heights of the sun above the horizon, degrees.
const SUN_HEIGHTS: &[f64] = &[0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0];
/// Scales of a scene.
const SCALES: &[f64] = &[1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3, 1e4];
/// Distances from the origin, metres.
const DISTANCES: &[f64] = &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6];
/// Sides of maps, texels.
const MAP_SIZES: &[f64] = &[64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0, 4096.0];

pub(super) const ALL: &[ReachSweep] = &[
    ReachSweep {
        title: "light angle: a row of spheres",
        x: "sun above the horizon, degrees",
        vary: under_sun,
        ..kind("angle", "low-sun-5", SUN_HEIGHTS)
    },
    ReachSweep {
        title: "scale: cubes",
        x: "scale",
        vary: scale,
        ..kind("scale", "cubes", SCALES)
    },
    ReachSweep {
        title: "distance from the origin: cubes",
        x: "distance, m",
        vary: scene_at_distance,
        ..kind("distance", "cubes", DISTANCES)
    },
    ReachSweep {
        title: "map size: cubes",
        x: "map side, texels",
        is_map_size: true,
        ..kind("map-size", "cubes", MAP_SIZES)
    },
];

/// Techniques with a curve: few enough to distinguish in a chart.
const TECHNIQUES: [&str; 4] = ["hard", "pcf", "second_depth", "volumes"];

pub(super) fn sweep(
    kind: &ReachSweep,
    options: &StabilityOptions,
    backends: &SharedBackends<'_>,
) -> Result<Sweep, LabError> {
    // Prepare the curve of the perfect map; those of techniques follow at the first value.
    let scene = umbrage_scenes::find(kind.scene)
        .map(|entry| (entry.build)())
        .unwrap_or_default();
    let mut perfect_map = Curve {
        label: "perfect map".to_owned(),
        points: Vec::new(),
    };
    let mut of_techniques = Vec::new();
    let mut disagreeing = None;
    for (place, &value) in kind.values.iter().enumerate() {
        // Trace truth of the scene at this value.
        let map_size = if kind.is_map_size {
            value as u32
        } else {
            options.map_size
        };
        let variant = (kind.vary)(&scene, value);
        let case_truth = truth_of(variant, map_size, options)?;
        let error_of_ideal = Measure::Rmse.figure(&case_truth, &case_truth.ideal);
        perfect_map.points.push([value, error_of_ideal]);
        let techniques = settings(
            &options.catalogue,
            &TECHNIQUES.map(str::to_owned),
            map_size,
            Fit::Tight,
        );
        // Start the curves at the first value: the settings differ only in the map's side.
        if of_techniques.is_empty() {
            of_techniques = techniques
                .iter()
                .map(|technique| empty_curve(technique, map_size))
                .collect();
        }
        // Render each technique, and add a point to its curve.
        for (technique, curve) in techniques.iter().zip(&mut of_techniques) {
            let rendered = render_point(&case_truth, technique, backends, place, kind.values.len());
            match rendered {
                Ok(rendered) => {
                    let error = Measure::Rmse.figure(&case_truth, &rendered.mask);
                    curve.points.push([value, error]);
                    disagreeing = all_backends::sum(disagreeing, rendered.disagreeing);
                }
                Err(NoMask::Unsupported(_)) => {}
                Err(NoMask::Fault(what)) => {
                    return Err(sweep_error(&case_truth, technique, &what));
                }
            }
        }
    }
    let mut curves = vec![perfect_map];
    curves.extend(of_techniques);
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

/// Traces truth for the scene's first camera and first light.
fn truth_of(
    scene: Scene,
    map_size: u32,
    options: &StabilityOptions,
) -> Result<CaseTruth, LabError> {
    let camera = scene.cameras[0].with_size(options.size);
    let lights = scene.lights[..1].to_vec();
    CaseTruth::new(scene, camera, lights, map_size, &options.truth)
}

/// Returns the curve of a setting, without points. Its label omits the map's side, which is on the
/// x axis or equal for all curves.
fn empty_curve(technique: &TechniquePreset, map_size: u32) -> Curve {
    let label = format!("{} ({})", technique.name(), technique.settings());
    Curve {
        label: label.replace(&format!("{map_size}, "), ""),
        points: Vec::new(),
    }
}
