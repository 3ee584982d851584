//! Writes plans to disk: the preset, the plan with its reasons, and the curve from which the bias
//! was chosen.

mod bias_curve;
mod regret_table;
mod strip;

pub use bias_curve::curve_figure;
pub use regret_table::{RegretLine, write_regret};

use crate::{
    error::LabError,
    output::{csv, folder::Folder, slug},
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use umbrage_core::Scene;
use umbrage_plan::{Bounds, CurvePoint, LightsPlan, Plan, PlanOptions, Setting, look};

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Content of the file: `preset`, `plan`, `bias curve`, `bias chart`, `images` or
    /// `plan of all lights`.
    pub what: &'static str,
    /// Path of the file.
    pub path: PathBuf,
}

/// Writes a plan into a folder, which is created if necessary. File names begin with the scene's
/// name:
///
/// * `cubes.preset.toml`: the [`LightPreset`](umbrage_techniques::LightPreset), if a setting was
///   found. A scene file `cubes.toml` is kept.
/// * `cubes.plan.json`: the [`Plan`].
/// * `cubes.bias.csv` and `cubes.bias.svg`: the bias curve, if the bias was found by a search.
/// * `cubes.strip.png`: truth, the chosen setting and cheaper failing ones with their errors. Needs
///   the scene and its options.
///
/// For lights other than the first, names are `cubes.light-2.preset.toml` and so on. Files are
/// written atomically. Files of an older plan that this one doesn't have are removed.
///
/// # Errors
/// Errors if a file can't be written, or a setting of the plan can't be executed.
pub fn write(
    plan: &Plan,
    planned: Option<(&Scene, &PlanOptions)>,
    folder: &Path,
) -> Result<Vec<Written>, LabError> {
    let failing: Vec<&Setting> = plan.failing.iter().collect();
    let picture = match (&plan.chosen, planned) {
        (Some(chosen), Some((scene, options))) => Some(picture(
            scene,
            options,
            &plan.bounds,
            chosen,
            "cheaper, fails",
            &failing,
        )?),
        _ => None,
    };
    let stem = stem(&plan.scene, plan.light_number);
    write_files(&stem, files(plan, picture)?, folder)
}

/// Writes the plan of all lights of a scene into a folder: `night-room.lights.json` (the
/// [`LightsPlan`]), and for each light its preset and its strip of images, as [`write()`] does.
///
/// # Errors
/// Errors if a file can't be written, or a setting of the plan can't be executed.
pub fn write_lights(
    plan: &LightsPlan,
    scene: &Scene,
    options: &PlanOptions,
    folder: &Path,
) -> Result<Vec<Written>, LabError> {
    // Write the plan of all lights.
    let json = serde_json::to_string_pretty(plan).map_err(|e| LabError::write("plan", e))?;
    let whole = PlanFile {
        what: "plan of all lights",
        ending: ".lights.json",
        bytes: Some(json.into_bytes()),
    };
    let mut written = write_files(&stem(&plan.scene, 1), vec![whole], folder)?;
    // Write the preset and the images of each light.
    for light in &plan.lights {
        let preset = match plan.light_preset(light) {
            Some(preset) => Some(preset.to_toml()?.into_bytes()),
            None => None,
        };
        let mut strip = None;
        if let Some(chosen) = &light.chosen {
            let place = light.front.iter().position(|s| s.preset == chosen.preset);
            // Show the next cheaper settings, most expensive first.
            let cheaper: Vec<&Setting> = light.front[..place.unwrap_or(0)]
                .iter()
                .rev()
                .take(2)
                .collect();
            let options = PlanOptions {
                light: light.number - 1,
                ..options.clone()
            };
            strip = Some(picture(
                scene,
                &options,
                &plan.limits,
                chosen,
                "cheaper",
                &cheaper,
            )?);
        }
        let files = vec![
            PlanFile {
                what: "preset",
                ending: ".preset.toml",
                bytes: preset,
            },
            PlanFile {
                what: "images",
                ending: ".strip.png",
                bytes: strip,
            },
        ];
        written.extend(write_files(
            &stem(&plan.scene, light.number),
            files,
            folder,
        )?);
    }
    Ok(written)
}

/// Returns the start of a light's file names.
fn stem(scene: &str, light_number: usize) -> String {
    match light_number {
        1 => slug(scene),
        n => format!("{}.light-{n}", slug(scene)),
    }
}

fn write_files(stem: &str, files: Vec<PlanFile>, folder: &Path) -> Result<Vec<Written>, LabError> {
    let into = Folder::create(folder)?;
    let mut written = Vec::new();
    for file in files {
        let name = format!("{stem}{}", file.ending);
        match file.bytes {
            Some(bytes) => {
                into.write(&name, &bytes)?;
                written.push(Written {
                    what: file.what,
                    path: folder.join(name),
                });
            }
            None => into.remove(&name)?,
        }
    }
    Ok(written)
}

/// Returns the strip of images of a setting and of others. `role` labels the others.
fn picture(
    scene: &Scene,
    options: &PlanOptions,
    bounds: &Bounds,
    chosen: &Setting,
    role: &str,
    others: &[&Setting],
) -> Result<Vec<u8>, LabError> {
    let mut presets = vec![chosen.preset.clone()];
    presets.extend(others.iter().map(|setting| setting.preset.clone()));
    let look = look(
        scene,
        &presets,
        bounds.renderer,
        options,
        strip::WIDTH,
        &|_| {},
    )?;
    strip::strip(&look, chosen, role, others)
}

/// A file of a plan.
struct PlanFile {
    /// [`Written::what`].
    what: &'static str,
    /// End of its name.
    ending: &'static str,
    /// Content of the file. `None` if the plan doesn't have it.
    bytes: Option<Vec<u8>>,
}

fn files(plan: &Plan, picture: Option<Vec<u8>>) -> Result<Vec<PlanFile>, LabError> {
    let preset = match plan.light_preset() {
        Ok(preset) => Some(preset.to_toml()?.into_bytes()),
        Err(_) => None,
    };
    let json = serde_json::to_string_pretty(plan).map_err(|e| LabError::write("plan", e))?;
    let curve = if plan.curve.is_empty() {
        None
    } else {
        let table = csv::of_records("bias curve", plan.curve.iter().map(CurveLine::from))?;
        Some(table)
    };
    let chart = curve_figure(plan).map(|figure| figure.svg().into_bytes());
    Ok(vec![
        PlanFile {
            what: "preset",
            ending: ".preset.toml",
            bytes: preset,
        },
        PlanFile {
            what: "plan",
            ending: ".plan.json",
            bytes: Some(json.into_bytes()),
        },
        PlanFile {
            what: "bias curve",
            ending: ".bias.csv",
            bytes: curve,
        },
        PlanFile {
            what: "bias chart",
            ending: ".bias.svg",
            bytes: chart,
        },
        PlanFile {
            what: "images",
            ending: ".strip.png",
            bytes: picture,
        },
    ])
}

/// A line of the bias curve: acne falls with the bias, the gap grows.
#[derive(Serialize)]
struct CurveLine {
    kind: &'static str,
    texels: f32,
    too_dark: f64,
    too_light: f64,
    error: f64,
    chosen: bool,
}

impl From<&CurvePoint> for CurveLine {
    fn from(point: &CurvePoint) -> Self {
        Self {
            kind: point.kind.name(),
            texels: point.texels,
            too_dark: point.estimate.too_dark,
            too_light: point.estimate.too_light,
            error: point.estimate.error,
            chosen: point.chosen,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use umbrage_plan::{BiasKind, Coverage, Estimate, Sampled, motion::FrameMotion};
    use umbrage_techniques::TechniquePreset;

    fn plan(scene: &str, chosen: bool) -> Plan {
        let estimate = Estimate {
            error: 0.25,
            too_dark: 0.125,
            ..Estimate::default()
        };
        let preset = TechniquePreset::defaults()[0].clone();
        let setting = Setting {
            preset: preset.clone(),
            technique: preset.technique().name().to_owned(),
            settings: String::new(),
            estimate,
            milliseconds: 1.0,
            draw_ms: 0.5,
            kept_as_camera_moves: Some(true),
            bytes: 4,
            grain: Some(0.125),
            shimmer: None,
            measured_ms: None,
            cameras: Vec::new(),
        };
        let point = CurvePoint {
            kind: BiasKind::NormalOffset,
            texels: 0.5,
            estimate,
            chosen: true,
        };
        Plan {
            scene: scene.to_owned(),
            light: "parallel".to_owned(),
            light_number: 1,
            size: [4, 3],
            cameras: 1,
            motion: FrameMotion::Still,
            bounds: Bounds::error(0.5),
            chosen: chosen.then_some(setting),
            miss: None,
            runners_up: Vec::new(),
            failing: Vec::new(),
            timed: Vec::new(),
            error_of_no_shadow: Estimate::default(),
            reasons: Vec::new(),
            left_out: Vec::new(),
            curve: if chosen { vec![point] } else { Vec::new() },
            coverage: Coverage::default(),
            sampled: Sampled::default(),
        }
    }

    #[test]
    fn plans_come_back_from_their_files() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let plan = plan("../A scene", true);
        let written = write(&plan, None, &dir.path().join("plans")).expect("writable");
        let mut names = Vec::new();
        for file in &written {
            let name = file.path.file_name().expect("named");
            names.push(name.to_string_lossy().into_owned());
        }
        assert_eq!(
            names,
            [
                "a-scene.preset.toml",
                "a-scene.plan.json",
                "a-scene.bias.csv",
                "a-scene.bias.svg"
            ]
        );
        let text = |i: usize| fs::read_to_string(&written[i].path).expect("there");
        assert_eq!(
            TechniquePreset::from_toml(&text(0)).expect("a preset"),
            TechniquePreset::defaults()[0]
        );
        assert_eq!(
            serde_json::from_str::<Plan>(&text(1)).expect("a plan"),
            plan
        );
        assert_eq!(
            text(2),
            "kind,texels,too_dark,too_light,error,chosen\nnormal offset,0.5,0.125,0.0,0.25,true\n"
        );
        assert!(text(3).contains("</svg>"));
        assert_eq!(
            fs::read_dir(dir.path().join("plans"))
                .expect("there")
                .count(),
            4,
            "nothing unfinished is left"
        );
    }

    /// The plan of a light must not overwrite another's.
    #[test]
    fn lights_have_files_of_their_own() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let second = Plan {
            light_number: 2,
            ..plan("cubes", true)
        };
        for plan in [plan("cubes", true), second] {
            write(&plan, None, dir.path()).expect("writable");
        }
        assert_eq!(fs::read_dir(dir.path()).expect("there").count(), 8);
        assert!(dir.path().join("cubes.light-2.preset.toml").exists());
    }

    /// An obsolete preset must not remain.
    #[test]
    fn what_an_older_plan_left_is_removed_and_a_scene_file_is_not() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        fs::write(dir.path().join("cubes.toml"), "a scene").expect("writable");
        write(&plan("cubes", true), None, dir.path()).expect("writable");
        let written = write(&plan("cubes", false), None, dir.path()).expect("writable");
        assert_eq!(written.iter().map(|w| w.what).collect::<Vec<_>>(), ["plan"]);
        assert!(
            !dir.path().join("cubes.preset.toml").exists()
                && dir.path().join("cubes.plan.json").exists()
        );
        assert_eq!(
            fs::read(dir.path().join("cubes.toml")).expect("there"),
            b"a scene"
        );
    }
}
