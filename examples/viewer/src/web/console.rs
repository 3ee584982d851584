//! Functions for tests and debugging in the browser's console. All return JSON: `umbrage_report()`
//! the displayed settings and their errors, `umbrage_agreement()` the agreement of the device's
//! masks with the CPU's, `umbrage_widgets()` the positions of the panel's parts.

use crate::{app::App, report};
use eframe::WebRunner;
use serde_json::Value;
use wasm_bindgen::{JsValue, closure::Closure};

/// Adds the functions to the page.
pub(super) fn offer(runner: &WebRunner, ctx: &egui::Context) {
    let widgets_ctx = ctx.clone();
    offer_one("umbrage_widgets", move || {
        // Draw a frame, whose positions the next call returns.
        widgets_ctx.request_repaint();
        report::widgets(&widgets_ctx)
    });
    let (report_runner, report_ctx) = (runner.clone(), ctx.clone());
    offer_one("umbrage_report", move || {
        let app = report_runner.app_mut::<App>();
        app.map_or(Value::Null, |app| report_of_page(&app, &report_ctx))
    });
    let agreement_runner = runner.clone();
    offer_one("umbrage_agreement", move || {
        let app = agreement_runner.app_mut::<App>();
        app.map_or(Value::Null, |app| report::agreement(&app.viewer))
    });
}

fn offer_one(name: &str, value: impl Fn() -> Value + 'static) {
    let function = Closure::<dyn Fn() -> String>::new(move || value().to_string()).into_js_value();
    // Ignore a page that refuses new names: it has no tests that call them.
    js_sys::Reflect::set(&js_sys::global(), &JsValue::from_str(name), &function).ok();
}

fn report_of_page(app: &App, ctx: &egui::Context) -> Value {
    let loading = app.viewer.loading.as_ref();
    let mut out = report::report(&app.viewer);
    out["reading"] = loading.map(|loading| loading.request.name.as_str()).into();
    out["frames"] = ctx.cumulative_frame_nr().into();
    out["first_frame_ms"] = app.first_frame_ms.unwrap_or(0.0).into();
    out
}
