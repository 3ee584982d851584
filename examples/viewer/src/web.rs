//! The program in a browser: its canvas, and what the page says where it can't run.

use crate::{app::App, device::device_descriptor, state::Start};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::sync::Arc;
use wasm_bindgen::JsCast as _;
use web_sys::{Document, HtmlCanvasElement};

/// Id of the page's canvas.
const CANVAS: &str = "umbrage";
/// Id of the element that says what goes on until the first picture.
const STATUS: &str = "status";

fn document() -> Option<Document> {
    web_sys::window()?.document()
}

fn say(text: &str) {
    if let Some(status) = document().and_then(|document| document.get_element_by_id(STATUS)) {
        status.set_text_content(Some(text));
    }
}

/// Starts the program in the page's canvas.
pub(crate) fn main() {
    eframe::WebLogger::init(log::LevelFilter::Warn).ok();
    wasm_bindgen_futures::spawn_local(async {
        match run().await {
            Ok(()) => {
                if let Some(status) =
                    document().and_then(|document| document.get_element_by_id(STATUS))
                {
                    status.remove();
                }
            }
            Err(error) => say(&format!("The viewer can't run here: {error}")),
        }
    });
}

async fn run() -> Result<(), String> {
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
    let creator: eframe::AppCreator<'static> = Box::new(|context| {
        let app = App::new(context, Start::default(), Arc::default())?;
        Ok(Box::new(app))
    });
    eframe::WebRunner::new()
        .start(canvas, options, creator)
        .await
        .map_err(|error| format!("{error:?}"))
}
