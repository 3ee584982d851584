//! What tests and curious people read of the program, from the browser's console: `umbrage_report()` tells what is shown and how wrong
//! it is, `umbrage_agreement()` compares the device's masks with the CPU's, `umbrage_widgets()` tells where the panel's parts lie. All
//! return JSON.

use super::widgets::Widgets;
use crate::{app::App, measure::against_cpu};
use eframe::WebRunner;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicU32, Ordering};
use wasm_bindgen::{JsValue, closure::Closure};

/// Milliseconds from the page's begin to its first frame, rounded; 0 before.
static FIRST_FRAME: AtomicU32 = AtomicU32::new(0);

/// Notes that the first frame was submitted.
pub(super) fn note_first_frame() {
    let now = web_sys::window().and_then(|window| window.performance());
    let milliseconds = now.map_or(0.0, |clock| clock.now());
    FIRST_FRAME.store(milliseconds as u32, Ordering::Relaxed);
}

/// Gives the page the functions.
pub(super) fn offer(runner: &WebRunner, ctx: &egui::Context) {
    let ctx = ctx.clone();
    offer_one("umbrage_widgets", move || Widgets::told(&ctx));
    for (name, told) in [
        ("umbrage_report", report as fn(&App) -> Value),
        ("umbrage_agreement", agreement),
    ] {
        let runner = runner.clone();
        offer_one(name, move || {
            // None before the program has started, and once it has failed.
            let app = runner.app_mut::<App>();
            app.map_or(Value::Null, |app| told(&app))
        });
    }
}

fn offer_one(name: &str, tell: impl Fn() -> Value + 'static) {
    let function = Closure::<dyn Fn() -> String>::new(move || tell().to_string()).into_js_value();
    // A page that refuses new names has no tests that ask.
    js_sys::Reflect::set(&js_sys::global(), &JsValue::from_str(name), &function).ok();
}

fn report(app: &App) -> Value {
    let truth = app.figures.truth.as_ref();
    let side = |i: usize| {
        let error = app.figures.sides[i].error;
        json!({
            "technique": app.settings.sides[i].preset.technique().name(),
            "label": app.settings.sides[i].label(),
            "refusals": app.renderer.sides[i].refusals(),
            "rmse": error.map(|e| e.rmse),
            "wrong": error.map(|e| (e.wrong * e.pixels as f64).round()),
            "pixels": error.map(|e| e.pixels),
        })
    };
    json!({
        "scene": app.stage.name,
        "triangles": app.stage.geometry.triangles().len(),
        "first_frame_ms": FIRST_FRAME.load(Ordering::Relaxed),
        "split": app.settings.split,
        "shown_side": app.settings.shown_side,
        "picture": app.settings.picture,
        "size": truth.map(|t| t.receivers.size.to_array()),
        "truth": truth.map(|t| t.progress),
        "sides": [side(0), side(1)],
        "message": app.message,
    })
}

fn agreement(app: &App) -> Value {
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
