//! The program in a browser: its canvas, the page's status line at start and end, and functions for
//! the console.

mod console;
mod in_worker;
mod query;
pub(crate) mod scenes;
pub(crate) mod worker;

use crate::{
    app::{App, Reports},
    device::{Slot, device_descriptor},
};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use query::Query;
use std::sync::{Arc, Once};
use wasm_bindgen::JsCast as _;
use web_sys::{Document, HtmlCanvasElement};

/// Id of the page's canvas.
const CANVAS: &str = "umbrage";
/// Id of the status line.
const STATUS: &str = "status";

fn document() -> Option<Document> {
    web_sys::window()?.document()
}

fn status() -> Option<web_sys::Element> {
    document()?.get_element_by_id(STATUS)
}

/// Shows a text in the status line.
fn say(text: &str) {
    if let Some(status) = status() {
        status.set_text_content(Some(text));
        status.remove_attribute("hidden").ok();
    }
}

fn say_nothing() {
    if let Some(status) = status() {
        status.set_attribute("hidden", "").ok();
    }
}

/// Starts the program in the page's canvas. In a worker, which has no window, it only registers the
/// function for tasks.
pub(crate) fn main() {
    if web_sys::window().is_none() {
        in_worker::offer();
        return;
    }
    eframe::WebLogger::init(log::LevelFilter::Warn).ok();
    wasm_bindgen_futures::spawn_local(async {
        if let Err(error) = run().await {
            say(&format!("The viewer can't run here: {error}"));
        }
    });
}

async fn run() -> Result<(), String> {
    say("Opening the graphics device\u{2026}");
    let canvas = document()
        .and_then(|document| document.get_element_by_id(CANVAS))
        .and_then(|element| element.dyn_into::<HtmlCanvasElement>().ok())
        .ok_or("the page has no canvas")?;
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
    setup.device_descriptor = Arc::new(device_descriptor);
    let options = eframe::WebOptions {
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..WgpuConfiguration::default()
        },
        ..eframe::WebOptions::default()
    };
    let runner = eframe::WebRunner::new();
    let of_app = runner.clone();
    let creator: eframe::AppCreator<'static> = Box::new(move |context| {
        let mut query = Query::of_page();
        let reports = Reports::default();
        let lost = reports.lost.clone();
        let start = std::mem::take(&mut query.start);
        let mut app = App::new(context, start, reports)?;
        query.first_shown.apply(&mut app.viewer.settings);
        app.viewer.first_shown = Some(query.first_shown);
        watch(&context.egui_ctx, lost);
        console::offer(&of_app, &context.egui_ctx);
        Ok(Box::new(app))
    });
    runner
        .start(canvas, options, creator)
        .await
        .map_err(|error| error.as_string().unwrap_or_else(|| format!("{error:?}")))
}

/// Hides the status line after the first frame, and reports the loss of the device there: a page
/// can't reopen its window.
fn watch(ctx: &egui::Context, lost: Slot<String>) {
    let first = Once::new();
    let at_end = move |_: &mut egui::Ui| {
        first.call_once(say_nothing);
        if let Some(loss) = lost.take() {
            say(&format!("{loss} Load the page again."));
        }
    };
    ctx.on_end_pass("page", Arc::new(at_end));
}
