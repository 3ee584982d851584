//! Reports as JSON, for tests and debugging: the displayed settings, their errors, and positions of
//! the panel's parts.

use crate::{lights::EditLight, measure::agreement, viewer::Viewer};
use serde_json::{Value, json};
use umbrage::glam::Vec3;

/// Returns the displayed settings and their errors.
pub(crate) fn report(viewer: &Viewer) -> Value {
    let Viewer {
        settings,
        renderer,
        figures,
        handles,
        ..
    } = viewer;
    let truth = figures.truth.as_ref();
    let side = |i: usize| {
        let error = figures.sides[i].error;
        json!({
            "technique": settings.sides[i].preset.technique().name(),
            "label": settings.sides[i].label(),
            "refusals": renderer.sides[i].refusals(),
            "refusal": figures.sides[i].refusal,
            "rmse": error.map(|e| e.rmse),
            "wrong": error.map(|e| e.wrong),
            "pixels": error.map(|e| e.pixels),
            "ambiguous": error.map(|e| e.ambiguous),
            "lookup_ms": figures.sides[i].lookup_ms,
        })
    };
    let plan = viewer.plan.as_ref();
    json!({
        "scene": viewer.stage.name,
        "loading": viewer.loading.as_ref().map(|loading| loading.label()),
        "frames": viewer.frames,
        "folded": settings.panel_is_folded,
        "path": viewer.path.as_ref().map(|path| json!({
            "name": path.moving.name,
            "playing": path.is_running,
            "step": path.index(),
        })),
        "zoom": settings.zoom,
        "pixels_per_point": handles.pixels_per_point(),
        "camera": viewer.camera.map(|camera| camera.eye().to_array()),
        "triangles": viewer.stage.geometry.triangles().len(),
        "split": settings.split,
        "shown_side": settings.shown_side,
        "picture": settings.picture,
        "size": truth.map(|t| t.receivers.size.to_array()),
        "truth": truth.map(|t| t.progress),
        "sides": [side(0), side(1)],
        "lights": settings.lights.iter().map(light).collect::<Vec<_>>(),
        "chosen": settings.chosen,
        "handles": viewer.marker.map(|at| [at.x, at.y]),
        "plan": plan.map(|(plan, _)| plan.chosen.as_ref().map(|chosen| chosen.label())),
        "planning": viewer.planning.as_ref().map(|(job, _)| job.step()),
        "refused": viewer.refused,
        "scale": viewer.pace.scale,
        "interval_ms": 1000.0 * viewer.pace.interval.as_secs_f64(),
        "message": viewer.message,
        "focus": viewer.focus.at.map(|at| [at.min.x, at.min.y, at.max.x, at.max.y]),
        "help": settings.shows_help,
        "maps": settings.shows_maps,
        "turns": handles.turns,
    })
}

fn light(light: &EditLight) -> Value {
    json!({
        "kind": light.light.kind(),
        "position": light.light.position().map(|position| position.to_array()),
        "toward": light.light.direction_from(Vec3::ZERO).to_array(),
        "is_on": light.is_on,
    })
}

/// Returns the agreement of the device's masks with the CPU's.
pub(crate) fn agreement(viewer: &Viewer) -> Value {
    let measured = viewer.subject().zip(viewer.figures.truth.as_ref());
    let side = |i: usize| {
        let Some((subject, truth)) = &measured else {
            return Value::Null;
        };
        let technique = viewer.settings.sides[i].technique(&subject.light);
        let mask = viewer.figures.sides[i].mask.as_deref();
        match agreement::agree(subject, &truth.receivers, &*technique, mask) {
            Ok((snapping, agreement)) => json!({
                "technique": technique.name(),
                "rounding": snapping.to_string(),
                "pixels": agreement.compared,
                "differing": agreement.differing,
                "largest": agreement.largest,
                "undecided": agreement.undecided,
                "decided_off": agreement.violations,
            }),
            Err(error) => json!({ "technique": technique.name(), "error": format!("{error:#}") }),
        }
    };
    json!({ "sides": [side(0), side(1)] })
}

/// Positions of the panel's parts, as screen readers receive them. Tests find their targets by
/// label.
#[derive(Default)]
struct Widgets {
    parts: Vec<Value>,
}

/// Returns the parts of the last frame: role, label, value, and the rectangle in points as left,
/// top, right and bottom. Empty until the frame after the first call.
pub(crate) fn widgets(ctx: &egui::Context) -> Value {
    ctx.add_plugin(Widgets::default());
    ctx.enable_accesskit();
    ctx.with_plugin(|widgets: &mut Widgets| Value::Array(widgets.parts.clone()))
        .unwrap_or_default()
}

impl egui::Plugin for Widgets {
    fn debug_name(&self) -> &'static str {
        "widgets"
    }

    fn output_hook(&mut self, _: &egui::Context, output: &mut egui::FullOutput) {
        let Some(update) = output.platform_output.accesskit_update.take() else {
            return;
        };
        let part = |node: &egui::accesskit::Node| {
            let at = node.bounds()?;
            Some(json!({
                "role": format!("{:?}", node.role()),
                "label": node.label(),
                "value": node.value(),
                "at": [at.x0, at.y0, at.x1, at.y1],
            }))
        };
        self.parts = update.nodes.iter().filter_map(|(_, n)| part(n)).collect();
    }
}

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use file::ReportFile;

#[cfg(not(target_arch = "wasm32"))]
mod file {
    use super::{Value, Viewer, agreement, json, report, widgets};
    use anyhow::{Context as _, Result};
    use std::{fs, path::PathBuf};

    /// A file with the report of the last frame.
    pub(crate) struct ReportFile {
        path: PathBuf,
        written: String,
        /// Agreement of the current masks with the CPU's.
        agreement: Option<Value>,
    }

    impl ReportFile {
        pub(crate) fn new(path: PathBuf) -> Self {
            Self {
                path,
                written: String::new(),
                agreement: None,
            }
        }

        /// Writes the report if it changed.
        ///
        /// # Errors
        /// Returns an error if the file can't be written.
        pub(crate) fn update(&mut self, viewer: &Viewer, ctx: &egui::Context) -> Result<()> {
            // Discard it while recomputed masks are missing, which takes a frame or more.
            if !viewer.figures.is_complete() {
                self.agreement = None;
            } else if self.agreement.is_none() {
                self.agreement = Some(agreement(viewer));
            }
            let text = json!({
                "report": report(viewer),
                "agreement": self.agreement,
                "widgets": widgets(ctx),
            });
            let text = text.to_string();
            if text == self.written {
                return Ok(());
            }
            // Write another file and rename it, so that readers never see a partial report.
            let unfinished = self.path.with_extension("unfinished");
            let error = || format!("{} can't be written", self.path.display());
            fs::write(&unfinished, &text).with_context(error)?;
            fs::rename(&unfinished, &self.path).with_context(error)?;
            self.written = text;
            Ok(())
        }
    }
}
