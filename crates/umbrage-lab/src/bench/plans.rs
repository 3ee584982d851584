//! Times planning against drawing: a technique's recipe, made anew for each change of camera, light or casters, beside the maps
//! that the CPU player draws for it.

use super::paired::{Pair, Repetitions, paired};
use crate::LabError;
use std::time::Instant;
use umbrage_core::{Backend, Fit, Geometry, Light, Receivers, ShadowTechnique, View, glam::UVec2};
use umbrage_cpu::Cpu;
use umbrage_scenes::{Kind, SceneEntry};
use umbrage_techniques::{ShadowMap, TechniquePreset};

/// Image size, pixels.
const SCREEN: UVec2 = UVec2::new(1280, 720);
/// Side of the maps, texels.
const MAP: u32 = 2048;
/// How often a plan must fit into its casts.
const BAR: f64 = 4.0;
/// How far from the camera a stable fit goes, metres.
const STABLE_RANGE: f32 = 50.0;
/// The techniques that are planned. `pcss` plans twice under lights with an extent, and `midpoint` draws twice.
const TECHNIQUES: [&str; 3] = ["hard", "pcss", "midpoint"];

/// Times the plans of map techniques in the content scenes with these names (in all of them if there is none), for each light
/// and fit, and passes each result to `tell` as it comes.
///
/// # Errors
/// Errors if a scene can't be used, a technique can't serve it, or the CPU player fails.
pub fn plans(runs: usize, scenes: &[String], mut tell: impl FnMut(Pair)) -> Result<(), LabError> {
    let repetitions = Repetitions { warm_up: 1, runs };
    let mut cpu = Cpu::new();
    let wanted = |entry: &&SceneEntry| {
        let is_named = scenes.iter().any(|name| name == entry.name);
        is_named || (scenes.is_empty() && entry.kind == Kind::Content)
    };
    for entry in umbrage_scenes::all().iter().filter(wanted) {
        let scene = (entry.build)();
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].resized(SCREEN);
        let receivers = cpu.receivers(&camera, &geometry)?;
        for (number, light) in scene.lights.iter().enumerate() {
            let stage = Stage {
                name: format!("{}, {} light {number}", entry.name, light.kind()),
                view: View::new(&camera, light, &geometry),
                light,
                geometry: &geometry,
                receivers: &receivers,
            };
            for technique in techniques() {
                tell(stage.pair(&technique, repetitions, &mut cpu)?);
            }
        }
    }
    Ok(())
}

/// Where plans are timed.
struct Stage<'a> {
    name: String,
    view: View<'a>,
    light: &'a Light,
    geometry: &'a Geometry,
    receivers: &'a Receivers,
}

/// A technique, and whether it plans for what is seen.
struct Planned {
    technique: TechniquePreset,
    fit: &'static str,
    is_seen_known: bool,
}

/// Returns what is timed: each technique with each fit.
fn techniques() -> Vec<Planned> {
    let stable = Fit::Stable {
        range: STABLE_RANGE,
    };
    let fits = [
        ("tight fit", Fit::Tight, false),
        ("tight fit to seen points", Fit::Tight, true),
        ("stable fit", stable, false),
        ("whole fit", Fit::Whole, false),
    ];
    let mut out = Vec::new();
    for entry in TECHNIQUES
        .into_iter()
        .filter_map(umbrage_plan::catalogue::find)
    {
        let preset = (entry.technique.preset)();
        let map = preset.map().copied().unwrap_or_default();
        for (name, fit, is_seen_known) in fits {
            let map = ShadowMap {
                size: MAP,
                fit,
                ..map
            };
            out.push(Planned {
                technique: preset.with_map(map),
                fit: name,
                is_seen_known,
            });
        }
    }
    out
}

impl Stage<'_> {
    /// Times plans and casts of a technique in turn. What is known once a scene (boxes of its triangles) is known already.
    fn pair(
        &self,
        planned: &Planned,
        repetitions: Repetitions,
        cpu: &mut Cpu,
    ) -> Result<Pair, LabError> {
        let technique = &planned.technique;
        let plan = || {
            let view = View::new(self.view.camera, self.light, self.geometry);
            let view = if planned.is_seen_known {
                view.with_receivers(self.receivers)
            } else {
                view
            };
            technique.recipe(&view).map_err(LabError::Plan)
        };
        let recipe = plan()?;
        let seen = self.view.with_receivers(self.receivers);
        let paired = paired(
            repetitions,
            || {
                let start = Instant::now();
                let recipe = plan()?;
                let took = start.elapsed();
                drop(recipe);
                Ok::<_, LabError>(took)
            },
            || Ok(cpu.render(&seen, &recipe)?.timings.cast.unwrap_or_default()),
        )?;
        Ok(Pair {
            work: format!("{}, {}, {}", technique.name(), planned.fit, self.name),
            who: ["plan".to_owned(), "casts".to_owned()],
            ours: paired.ours,
            theirs: paired.theirs,
            ratio: paired.ratio,
            bar: Some(BAR),
            runs: repetitions.runs,
            fault: None,
        })
    }
}
