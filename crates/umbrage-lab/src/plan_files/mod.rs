//! Writes plans to disk: the preset to use, the plan with its reasons, and the curve from which the bias was chosen.

mod bias_curve;
mod regret_table;

pub use bias_curve::curve_figure;
pub use regret_table::{RegretLine, write_regret};

use crate::{
    LabError,
    output::{Folder, csv, slug},
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use umbrage_plan::{CurvePoint, Plan};

/// A file that was written, and what it holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// `preset`, `plan`, `bias curve` or `bias chart`.
    pub what: &'static str,
    /// Where it lies.
    pub path: PathBuf,
}

/// Writes a plan into a folder, which is made if need be, under the scene's name: `cubes.preset.toml` (the
/// [`TechniquePreset`](umbrage_techniques::TechniquePreset), where one was found; a scene file `cubes.toml` stays as it is), `cubes.plan.json`
/// (the [`Plan`]), and for biases that are found by trying `cubes.bias.csv` and `cubes.bias.svg`; for another light than the
/// first `cubes.light-2.preset.toml`, and so on. Each is there whole or not at all; those that an older plan had and this
/// one lacks are removed.
///
/// # Errors
/// Errors if a file cannot be written.
pub fn write(plan: &Plan, folder: &Path) -> Result<Vec<Written>, LabError> {
    let stem = match plan.light_number {
        1 => slug(&plan.scene),
        n => format!("{}.light-{n}", slug(&plan.scene)),
    };
    let into = Folder::create(folder)?;
    let mut written = Vec::new();
    for file in files(plan)? {
        let name = format!("{stem}{}", file.ending);
        match file.text {
            Some(text) => {
                into.write(&name, text.as_bytes())?;
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

/// One of a plan's files.
struct PlanFile {
    /// [`Written::what`].
    what: &'static str,
    /// How its name ends.
    ending: &'static str,
    /// What it holds; none where the plan has no such thing.
    text: Option<String>,
}

fn files(plan: &Plan) -> Result<[PlanFile; 4], LabError> {
    let preset = match &plan.chosen {
        Some(chosen) => Some(chosen.preset.to_toml()?),
        None => None,
    };
    let json = serde_json::to_string_pretty(plan).map_err(|e| LabError::write("plan", e))?;
    let curve = if plan.curve.is_empty() {
        None
    } else {
        let table = csv::of_records("bias curve", plan.curve.iter().map(CurveLine::from))?;
        Some(String::from_utf8_lossy(&table).into_owned())
    };
    let chart = curve_figure(plan).map(|figure| figure.svg());
    Ok([
        PlanFile {
            what: "preset",
            ending: ".preset.toml",
            text: preset,
        },
        PlanFile {
            what: "plan",
            ending: ".plan.json",
            text: Some(json),
        },
        PlanFile {
            what: "bias curve",
            ending: ".bias.csv",
            text: curve,
        },
        PlanFile {
            what: "bias chart",
            ending: ".bias.svg",
            text: chart,
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
    use umbrage_plan::{BiasKind, Bounds, Estimate, Sampled, Setting};
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
            bytes: 4,
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
            bounds: Bounds::error(0.5),
            chosen: chosen.then_some(setting),
            miss: None,
            runners_up: Vec::new(),
            reasons: Vec::new(),
            curve: if chosen { vec![point] } else { Vec::new() },
            sampled: Sampled::default(),
        }
    }

    #[test]
    fn plans_come_back_from_their_files() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let plan = plan("../A scene", true);
        let written = write(&plan, &dir.path().join("plans")).expect("writable");
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

    /// One light's plan must not take another's place.
    #[test]
    fn lights_have_files_of_their_own() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let second = Plan {
            light_number: 2,
            ..plan("cubes", true)
        };
        for plan in [plan("cubes", true), second] {
            write(&plan, dir.path()).expect("writable");
        }
        assert_eq!(fs::read_dir(dir.path()).expect("there").count(), 8);
        assert!(dir.path().join("cubes.light-2.preset.toml").exists());
    }

    /// A preset that no longer holds must not be taken for one that does.
    #[test]
    fn what_an_older_plan_left_is_removed_and_a_scene_file_is_not() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        fs::write(dir.path().join("cubes.toml"), "a scene").expect("writable");
        write(&plan("cubes", true), dir.path()).expect("writable");
        let written = write(&plan("cubes", false), dir.path()).expect("writable");
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
