//! What tests and curious people read of the program, from the browser's console: `umbrage_report()` tells what is shown and how wrong
//! it is, `umbrage_agreement()` compares the device's masks with the CPU's, `umbrage_widgets()` tells where the panel's parts lie. All
//! return JSON.

use crate::{
    app::App,
    told::{self, widgets::Widgets},
};
use eframe::WebRunner;
use serde_json::Value;
use std::sync::atomic::{AtomicU32, Ordering};
use wasm_bindgen::{JsValue, closure::Closure};

/// Milliseconds from the page's begin to its first frame with a scene, rounded; 0 before.
static FIRST_FRAME: AtomicU32 = AtomicU32::new(0);

/// Notes, if it is the first, that a frame with a scene was submitted.
pub(crate) fn note_frame() {
    if FIRST_FRAME.load(Ordering::Relaxed) != 0 {
        return;
    }
    let now = web_sys::window().and_then(|window| window.performance());
    let milliseconds = now.map_or(0.0, |clock| clock.now());
    FIRST_FRAME.store(milliseconds as u32, Ordering::Relaxed);
}

/// Gives the page the functions.
pub(super) fn offer(runner: &WebRunner, ctx: &egui::Context) {
    let of_widgets = ctx.clone();
    offer_one("umbrage_widgets", move || {
        // What the next frame has is told by the next call.
        of_widgets.request_repaint();
        Widgets::told(&of_widgets)
    });
    for (name, told) in [
        (
            "umbrage_report",
            report as fn(&App, &egui::Context) -> Value,
        ),
        ("umbrage_agreement", |app, _| told::agreement(app)),
    ] {
        let (runner, ctx) = (runner.clone(), ctx.clone());
        offer_one(name, move || {
            // None before the program has started, and once it has failed.
            let app = runner.app_mut::<App>();
            app.map_or(Value::Null, |app| told(&app, &ctx))
        });
    }
}

fn offer_one(name: &str, tell: impl Fn() -> Value + 'static) {
    let function = Closure::<dyn Fn() -> String>::new(move || tell().to_string()).into_js_value();
    // A page that refuses new names has no tests that ask.
    js_sys::Reflect::set(&js_sys::global(), &JsValue::from_str(name), &function).ok();
}

fn report(app: &App, ctx: &egui::Context) -> Value {
    let mut told = told::report(app);
    told["reading"] = app.loader.name().into();
    told["frames"] = ctx.cumulative_frame_nr().into();
    told["first_frame_ms"] = FIRST_FRAME.load(Ordering::Relaxed).into();
    told
}
