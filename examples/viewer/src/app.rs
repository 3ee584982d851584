//! The program in its window, and the steps of each frame.

#[cfg(not(target_arch = "wasm32"))]
use crate::report::ReportFile;
use crate::{
    bookmarks,
    device::Slot,
    loading::{Then, are_same_scene},
    pace::REST,
    panel,
    settings::{Settings, Start},
    viewer::{FIRST_SCENE, Viewer},
    zoom,
};
use anyhow::{Context as _, Result};
use std::sync::Arc;

/// Reports of the device's callbacks, and the interrupted work.
#[derive(Clone, Default)]
pub(crate) struct Reports {
    /// Reason of the device's loss.
    pub lost: Slot<String>,
    /// The scene that was loading when the device was lost.
    pub unfinished: Slot<String>,
    /// An error of the device that no call returned.
    error: Slot<String>,
}

/// The program in its window.
pub(crate) struct App {
    pub viewer: Viewer,
    reports: Reports,
    #[cfg(not(target_arch = "wasm32"))]
    report_file: Option<ReportFile>,
    /// Time from the start of the page to its first frame with a scene, milliseconds.
    #[cfg(target_arch = "wasm32")]
    pub first_frame_ms: Option<f64>,
}

impl App {
    /// Opens the first scene.
    ///
    /// # Errors
    /// Returns an error if there is no device, or it can't be used.
    pub(crate) fn new(
        context: &eframe::CreationContext<'_>,
        start: Start,
        reports: Reports,
    ) -> Result<Self> {
        let render = context.wgpu_render_state.clone().context(
            "no graphics device; install a graphics driver, such as Debian's mesa-vulkan-drivers",
        )?;
        let ctx = &context.egui_ctx;
        listen(&render.device, &reports, ctx);
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(seconds) = start.loses_device_after {
            let device = render.device.clone();
            std::thread::spawn(move || {
                std::thread::sleep(std::time::Duration::from_secs_f32(seconds.clamp(0.0, 1e6)));
                device.destroy();
            });
        }
        ctx.set_theme(egui::Theme::Dark);
        // The program's own keys change the zoom.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        // Choose the scene: the requested one, the saved one, or the first.
        let storage = context.storage.filter(|_| !start.is_fresh);
        let saved: Option<Settings> =
            storage.and_then(|storage| eframe::get_value(storage, eframe::APP_KEY));
        let saved_scene = saved.as_ref().map_or("", Settings::saved_scene).to_owned();
        let mut wanted = start.scene.into_iter().chain([saved_scene.clone()]);
        let wanted = wanted.find(|scene| !scene.is_empty());
        let wanted = wanted.unwrap_or_else(|| FIRST_SCENE.to_owned());
        let settings = Settings::new(saved.as_ref(), &start.techniques);
        let mut viewer = Viewer::new(render, settings)?;
        // Open it with the saved settings, or as a failure.
        let failure = bookmarks::find(&wanted).filter(|_| start.shows_failure);
        let scene = failure.map_or(wanted.as_str(), |failure| failure.scene);
        let then = match (failure, saved) {
            (Some(failure), _) => Then::Compare(failure),
            (None, Some(saved)) if are_same_scene(&saved_scene, &wanted) => {
                Then::AsLeft(Box::new(saved))
            }
            _ => Then::Show,
        };
        viewer.open(ctx, scene, then);
        viewer.message = start.message;
        Ok(Self {
            viewer,
            reports,
            #[cfg(not(target_arch = "wasm32"))]
            report_file: start.report.map(ReportFile::new),
            #[cfg(target_arch = "wasm32")]
            first_frame_ms: None,
        })
    }

    /// Records the time of the first frame with a scene.
    #[cfg(target_arch = "wasm32")]
    fn note_frame(&mut self) {
        if self.first_frame_ms.is_none() && !self.viewer.stage.is_nothing() {
            let clock = web_sys::window().and_then(|window| window.performance());
            self.first_frame_ms = clock.map(|clock| clock.now());
        }
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn write_report(&mut self, ctx: &egui::Context) {
        if let Some(file) = &mut self.report_file {
            let written = file.update(&self.viewer, ctx);
            self.viewer.check(written);
        }
    }
}

/// Registers the device's callbacks for errors and loss.
fn listen(device: &wgpu::Device, reports: &Reports, ctx: &egui::Context) {
    let error_slot = reports.error.clone();
    device.on_uncaptured_error(Arc::new(move |error| error_slot.put(error.to_string())));
    let (lost, wake) = (reports.lost.clone(), ctx.clone());
    device.set_device_lost_callback(move |reason, message| {
        lost.put(format!(
            "The graphics device was lost ({reason:?}): {message}"
        ));
        wake.request_repaint();
    });
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let ctx = &ui.ctx().clone();
        let viewer = &mut self.viewer;
        // Poll, so that a lost device reports its loss before the panel's painter requests memory.
        // The frame's passes return all other errors.
        let _ = viewer.render.device.poll(wgpu::PollType::Poll);
        if self.reports.lost.is_full() {
            let loading = viewer.loading.as_ref();
            if let Some(argument) = loading.and_then(|loading| loading.argument()) {
                self.reports.unfinished.put(argument.to_owned());
            }
            // Nothing can be drawn any longer: reopen the window with another device.
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        if let Some(error) = self.reports.error.take() {
            viewer.message = Some(error);
        }
        viewer.frames += 1;
        let passed = viewer.pace.begin();
        viewer.take_files(ctx);
        viewer.take_loaded(ctx);
        let lights = viewer.settings.lights.clone();
        viewer.keys(ctx);
        zoom::update(ctx, viewer.settings.zoom);
        viewer.save_screenshot();
        viewer.take_plan();
        panel::show(viewer, ui);
        if lights != viewer.settings.lights {
            viewer.pace.touch();
        }
        let frame = egui::Frame::NONE;
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            let drawn = viewer.show_picture(ui, passed);
            viewer.check(drawn);
            panel::over::show(viewer, ui);
        });
        let measured = viewer.measure(ctx);
        viewer.check(measured);
        if viewer.is_steered(ctx) || viewer.pace.is_fresh() {
            ctx.request_repaint();
        } else if viewer.figures.subject.is_none() || viewer.loading.is_some() {
            // Update the displayed time of loading. More frames would slow loading down.
            ctx.request_repaint_after(REST);
        }
        #[cfg(not(target_arch = "wasm32"))]
        self.write_report(ctx);
        #[cfg(target_arch = "wasm32")]
        self.note_frame();
    }

    /// Returns the panel's colour in the format of the window. Painting it with the panel's own
    /// shader took a fifth of the frame time of a large scene on a software driver.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        if self.viewer.render.target_format.is_srgb() {
            egui::Rgba::from(visuals.panel_fill).to_array()
        } else {
            visuals.panel_fill.to_normalized_gamma_f32()
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        let Viewer {
            stage, settings, ..
        } = &self.viewer;
        // Without a scene, keep the saved settings.
        if !stage.is_nothing() {
            eframe::set_value(storage, eframe::APP_KEY, &settings.to_save(stage));
        }
    }

    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}
