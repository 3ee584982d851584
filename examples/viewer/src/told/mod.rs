//! What tests and curious people read of the program, as JSON: what is shown, how wrong it is, and where the panel's parts lie.

#[cfg(not(target_arch = "wasm32"))]
pub(crate) mod file;
pub(crate) mod widgets;

use crate::{app::App, lights::EditLight, measure::against_cpu};
use serde_json::{Value, json};
use umbrage::glam::Vec3;

/// Returns what is shown, and how wrong it is.
pub(crate) fn report(app: &App) -> Value {
    let truth = app.figures.truth.as_ref();
    let side = |i: usize| {
        let error = app.figures.sides[i].error;
        json!({
            "technique": app.settings.sides[i].preset.technique().name(),
            "label": app.settings.sides[i].label(),
            "refusals": app.renderer.sides[i].refusals(),
            "refusal": app.figures.sides[i].refusal,
            "rmse": error.map(|e| e.rmse),
            "wrong": error.map(|e| (e.wrong * e.pixels as f64).round()),
            "pixels": error.map(|e| e.pixels),
            "ambiguous": error.map(|e| e.ambiguous),
            "lookup_ms": app.figures.sides[i].lookup_ms,
        })
    };
    json!({
        "scene": app.stage.name,
        "loading": app.loader.at(),
        "frames": app.frames,
        "folded": app.settings.panel_is_folded,
        "path": app.path.as_ref().map(|path| json!({
            "name": path.moving.name,
            "playing": path.is_playing,
            "step": path.index(),
        })),
        "zoom": app.settings.zoom,
        "pixels_per_point": app.pixels_per_point(),
        "camera": app.camera.map(|camera| camera.eye().to_array()),
        "triangles": app.stage.geometry.triangles().len(),
        "split": app.settings.split,
        "shown_side": app.settings.shown_side,
        "picture": app.settings.picture,
        "size": truth.map(|t| t.receivers.size.to_array()),
        "truth": truth.map(|t| t.progress),
        "sides": [side(0), side(1)],
        "lights": app.settings.lights.iter().map(told_light).collect::<Vec<_>>(),
        "chosen": app.settings.chosen,
        "handles": app.marker.map(|at| [at.x, at.y]),
        "plan": app.plan.as_ref().map(|(plan, _)| plan.chosen.as_ref().map(|chosen| chosen.label())),
        "planning": app.plan_job.at(),
        "refused": app.refused,
        "scale": app.scale,
        "interval_ms": 1000.0 * app.times.interval.as_secs_f64(),
        "message": app.message,
        "focus": app.focus.at.map(|at| [at.min.x, at.min.y, at.max.x, at.max.y]),
        "help": app.settings.shows_help,
        "maps": app.settings.shows_maps,
        "turns": app.handles.turns,
    })
}

/// Compares the device's masks with the CPU's.
pub(crate) fn agreement(app: &App) -> Value {
    let compared = against_cpu::Compared::of_app(app);
    let side = |i: usize| {
        let Some(compared) = &compared else {
            return Value::Null;
        };
        let technique = app.settings.sides[i].technique(&compared.light);
        match compared.agree(technique.as_ref(), app.figures.sides[i].mask.as_deref()) {
            Ok(found) => json!({
                "technique": technique.name(),
                "rounding": found.snapping.to_string(),
                "pixels": found.agreement.compared,
                "differing": found.agreement.differing,
                "largest": found.agreement.largest,
                "undecided": found.agreement.undecided,
                "decided_off": found.agreement.violations,
            }),
            Err(error) => json!({ "technique": technique.name(), "error": format!("{error:#}") }),
        }
    };
    json!({ "sides": [side(0), side(1)] })
}

fn told_light(light: &EditLight) -> Value {
    json!({
        "kind": light.light.kind(),
        "position": light.light.position().map(|place| place.to_array()),
        "toward": light.light.direction_from(Vec3::ZERO).to_array(),
        "is_on": light.is_on,
    })
}
