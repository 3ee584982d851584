//! The program: what is shown, what the user does with it, and what is measured meanwhile.

#[cfg(not(target_arch = "wasm32"))]
use crate::told::file::ToldFile;
use crate::{
    bookmarks,
    device::{Message, is_left, put, taken},
    focus::Focus,
    gizmo::{self, LightHandles},
    lights::Kind,
    loading::{Loader, Then, are_same_scene},
    measure::view_figures::{Question, ShownFigures, ViewFigures},
    panel::{self, maps::MapPicture, picker::Picker},
    path::MotionPath,
    plan_job::{PlanJob, PlanRequest, PlannedFor},
    render::{FrameSettings, Renderer, Shown, present::Presenter},
    stage::Stage,
    state::{FirstShown, Saved, Settings, Start},
    zoom,
};
use anyhow::{Context as _, Result};
use eframe::egui_wgpu::RenderState;
use std::sync::{Arc, Mutex, PoisonError};
use umbrage::{Camera, Light, glam::UVec2, plan::Plan};
use web_time::{Duration, Instant};

/// The scene that is shown when nobody names one.
pub(crate) const FIRST_SCENE: &str = "town";
/// Frames a second below which the picture gets coarser while something moves, on drivers that draw by the processor, and where the device has
/// no clock: there the rate may be the display's own.
const FLUENT_WITHOUT_CLOCK: f32 = 20.0;
/// The same on graphics cards with a clock.
const FLUENT: f32 = 60.0;
/// The least share of the picture's width and height that is drawn.
const COARSEST: f32 = 0.25;
/// Steps of the scale.
const SCALE_STEPS: f32 = 16.0;
/// How long nothing must have changed before errors are measured.
const REST: Duration = Duration::from_millis(250);
/// The same where frames take long.
const LONGEST_REST: Duration = Duration::from_millis(1500);

/// What frames took.
#[derive(Clone, Copy, Default)]
pub(crate) struct FrameTimes {
    /// From the begin of a frame to that of the next, smoothed, while frames follow each other.
    pub interval: Duration,
    /// Work on the CPU for a frame.
    pub work: Duration,
}

pub(crate) struct App {
    pub render: RenderState,
    pub stage: Stage,
    pub renderer: Renderer,
    pub settings: Settings,
    pub handles: LightHandles,
    pub scale: f32,
    pub times: FrameTimes,
    last_frame: Option<Instant>,
    /// Whether something moved in the last frame.
    was_moving: bool,
    presenter: Presenter,
    /// The camera of the last frame: its size is smaller than the picture's while something moves and frames take long.
    pub camera: Option<Camera>,
    /// The picture's size in the window, pixels.
    pixels: UVec2,
    changed: Instant,
    pub figures: ViewFigures,
    #[cfg(not(target_arch = "wasm32"))]
    told: Option<ToldFile>,
    /// Where the chosen light's marker is in the window, points.
    pub marker: Option<egui::Pos2>,
    pub plan_job: PlanJob,
    /// What the plan that is being made is for.
    plan_asked: Option<PlannedFor>,
    /// The techniques that the last plan left out.
    pub refused: Vec<String>,
    /// The last plan, and what it was made for.
    pub plan: Option<(Plan, PlannedFor)>,
    pub maps: [MapPicture; 2],
    /// How many steps nearer the user has asked for since the last frame.
    pub steps_nearer: f32,
    pub message: Option<String>,
    fault: Message,
    lost: Message,
    /// What was being loaded when the device was lost.
    unfinished: Message,
    screenshot: Arc<Mutex<Option<Arc<egui::ColorImage>>>>,
    pub loader: Loader,
    /// How the first scene is shown, if somebody asked: what else comes with it is set before.
    pub first_shown: Option<FirstShown>,
    /// What moves in a place of failure.
    pub path: Option<MotionPath>,
    /// The list from which the keyboard chooses, while it is open.
    pub picker: Option<Picker>,
    pub focus: Focus,
    /// Frames since the window was opened.
    pub frames: u64,
}

impl App {
    /// Opens the first scene. If the device is lost, `lost` is told why, and `unfinished` the scene that was being loaded.
    ///
    /// # Errors
    /// Errors if there is no device, or the scene can't be shown.
    pub(crate) fn new(
        context: &eframe::CreationContext<'_>,
        start: Start,
        lost: Message,
        unfinished: Message,
    ) -> Result<Self> {
        let render = context.wgpu_render_state.clone().context(
            "no graphics device; install a graphics driver, such as Debian's mesa-vulkan-drivers",
        )?;
        let fault = Message::default();
        let told_fault = fault.clone();
        render
            .device
            .on_uncaptured_error(Arc::new(move |error| put(&told_fault, error.to_string())));
        let loss = lost.clone();
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(seconds) = start.loses_device_after {
            let device = render.device.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_secs_f32(seconds.clamp(0.0, 1e6)));
                device.destroy();
            });
        }
        let wake = context.egui_ctx.clone();
        render
            .device
            .set_device_lost_callback(move |reason, message| {
                put(
                    &loss,
                    format!("The graphics device was lost ({reason:?}): {message}"),
                );
                wake.request_repaint();
            });
        let saved: Option<Saved> = match (start.is_fresh, context.storage) {
            (false, Some(storage)) => eframe::get_value(storage, eframe::APP_KEY),
            _ => None,
        };
        let wanted = start
            .scene
            .or_else(|| saved.as_ref().map(|saved| saved.scene.clone()))
            .filter(|scene| !scene.is_empty())
            .unwrap_or_else(|| FIRST_SCENE.to_owned());
        let stage = Stage::nothing();
        let settings = Settings::new(&stage, saved.as_ref(), &start.techniques);
        let sides = [&settings.sides[0], &settings.sides[1]];
        let renderer = Renderer::new(&render.device, &render.queue, &stage, sides)?;
        let wake = context.egui_ctx.clone();
        let ctx = &context.egui_ctx;
        ctx.set_theme(egui::Theme::Dark);
        // The list of keys has these.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        let mut app = Self {
            stage,
            renderer,
            settings,
            handles: LightHandles::default(),
            scale: 1.0,
            times: FrameTimes::default(),
            last_frame: None,
            was_moving: false,
            presenter: Presenter::new(&render.device, render.target_format),
            camera: None,
            pixels: UVec2::ONE,
            changed: Instant::now(),
            #[cfg(not(target_arch = "wasm32"))]
            told: start.told.map(ToldFile::new),
            figures: ViewFigures::new(move || wake.request_repaint()),
            marker: None,
            plan_job: PlanJob::default(),
            plan_asked: None,
            refused: Vec::new(),
            plan: None,
            maps: Default::default(),
            steps_nearer: 0.0,
            message: None,
            fault,
            lost,
            unfinished,
            screenshot: Arc::default(),
            loader: Loader::default(),
            path: None,
            first_shown: None,
            picker: None,
            focus: Focus::default(),
            frames: 0,
            render,
        };
        let failure = start
            .shows_failure
            .then(|| bookmarks::find(&wanted))
            .flatten();
        let scene = failure.map_or(wanted.as_str(), |failure| failure.scene);
        let then = match (failure, saved) {
            (Some(failure), _) => Then::Compare(failure),
            (None, Some(saved)) if are_same_scene(&saved.scene, &wanted) => {
                Then::AsLeft(saved.scene_as_left())
            }
            _ => Then::Show,
        };
        app.open(ctx, scene, then);
        app.message = start.message;
        Ok(app)
    }

    /// Notes that something changed.
    pub(crate) fn touch(&mut self) {
        self.changed = Instant::now();
    }

    /// Whether nothing has moved for a while.
    pub(crate) fn rests(&self) -> bool {
        // Where frames take longer than that, the next movement is still on its way.
        self.changed.elapsed() >= (2 * self.times.interval).clamp(REST, LONGEST_REST)
    }

    /// Pixels of the window for each point of the panel.
    pub(crate) fn pixels_per_point(&self) -> f32 {
        self.handles.pixels_per_point()
    }

    /// Returns the camera and the light that is measured; none while that is off.
    pub(crate) fn looked_at(&self) -> Option<(Camera, Light)> {
        let question = question(self.camera, &self.settings, &self.stage)?;
        Some((question.camera, question.light))
    }

    fn shown(&self) -> Shown {
        match self.settings.split {
            Some(divider) => Shown::Both(divider),
            None => Shown::One(self.settings.shown_side),
        }
    }

    /// Copies a side's settings for the chosen light, as a preset file has them.
    pub(crate) fn copy_preset(&mut self, ctx: &egui::Context, side: usize) {
        let Some(light) = self.settings.lights.get(self.settings.chosen) else {
            return;
        };
        match self.settings.sides[side].preset_text(&light.light) {
            Ok(text) => {
                ctx.copy_text(text);
                self.message = Some("The preset is in the clipboard.".to_owned());
            }
            Err(error) => self.message = Some(format!("{error:#}")),
        }
    }

    /// Draws the scene, and shows it in a part of the window.
    fn picture(&mut self, ui: &mut egui::Ui, passed: Duration) -> Result<()> {
        let rect = ui.available_rect_before_wrap();
        // Not a part that Tab goes to: there is nothing in it to be pressed.
        let response = ui.allocate_rect(rect, egui::Sense::CLICK | egui::Sense::DRAG);
        self.leave_path(|app| app.steer(ui, &response, passed));
        self.follow_path(passed);
        let pixels = pixels_of(rect, ui.ctx().pixels_per_point());
        self.pixels = pixels;
        let is_moving = !self.rests();
        if is_moving && self.was_moving {
            self.adapt(passed);
        }
        self.was_moving = is_moving;
        // In steps, so that textures are not made anew with every frame.
        let stepped = (self.scale * SCALE_STEPS).round() / SCALE_STEPS;
        let scale = if is_moving { stepped } else { 1.0 };
        let most = self.render.device.limits().max_texture_dimension_2d as f32;
        let side = |length: u32| (length as f32 * scale).round().clamp(1.0, most) as u32;
        let size = UVec2::new(side(pixels.x), side(pixels.y));
        let camera = self.camera_of_size(size);
        let begin = Instant::now();
        let shown = self.shown();
        let frame = FrameSettings {
            camera: &camera,
            stage: &self.stage,
            lights: &self.settings.lights,
            sides: [&self.settings.sides[0], &self.settings.sides[1]],
            shown,
            is_coarse: is_moving && scale < 1.0,
            prepares_both: !is_moving,
        };
        let view = self.renderer.frame(&frame)?;
        let presented = self.presenter.shape(rect, view, size, pixels);
        self.camera = Some(camera);
        self.times.work = begin.elapsed();
        ui.painter_at(rect).add(presented);
        self.divider(ui, rect);
        self.lights(ui, rect, &camera);
        if self.changed.elapsed() < REST {
            ui.ctx().request_repaint();
        }
        Ok(())
    }

    /// Returns the present camera for a picture of this size, pixels: where the path is, if one is under way.
    fn camera_of_size(&self, size: UVec2) -> Camera {
        let camera = self.settings.view.camera(size);
        match &self.path {
            Some(path) => path.camera(&camera),
            None => camera,
        }
    }

    /// Draws fewer pixels while something moves and frames take long, and more again once they don't.
    fn adapt(&mut self, passed: Duration) {
        let draws_by_processor =
            self.render.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let wanted = if draws_by_processor || !self.renderer.has_clock() {
            wanted_scale(self.scale, passed, FLUENT_WITHOUT_CLOCK)
        } else if let Some(timed) = self.renderer.take_moving_frame() {
            // It was drawn some frames ago.
            let scale = timed.size.x as f32 / self.pixels.x.max(1) as f32;
            wanted_scale(scale, timed.took.max(self.times.work), FLUENT)
        } else {
            return;
        };
        // Coarser at once, finer slowly.
        self.scale = if wanted < self.scale {
            wanted
        } else {
            0.8 * self.scale + 0.2 * wanted
        };
    }

    fn divider(&mut self, ui: &egui::Ui, rect: egui::Rect) {
        let Some(divider) = &mut self.settings.split else {
            return;
        };
        let x = egui::lerp(rect.x_range(), *divider);
        let grip = egui::Rect::from_x_y_ranges(x - 6.0..=x + 6.0, rect.y_range());
        let response = ui.interact(grip, ui.scope_id().with("divider"), egui::Sense::DRAG);
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        if let Some(pointer) = response.interact_pointer_pos()
            && response.dragged()
        {
            *divider = ((pointer.x - rect.min.x) / rect.width()).clamp(0.0, 1.0);
        }
        let painter = ui.painter_at(rect);
        painter.vline(
            x,
            rect.y_range(),
            egui::Stroke::new(3.0, egui::Color32::BLACK),
        );
        painter.vline(
            x,
            rect.y_range(),
            egui::Stroke::new(1.5, egui::Color32::WHITE),
        );
    }

    fn lights(&mut self, ui: &egui::Ui, rect: egui::Rect, camera: &Camera) {
        let settings = &mut self.settings;
        let looked_at = &settings.view.looked_at();
        gizmo::markers(
            ui,
            rect,
            camera,
            looked_at,
            &settings.lights,
            &mut settings.chosen,
        );
        let mut has_moved = false;
        self.marker = None;
        if let Some(light) = settings.lights.get_mut(settings.chosen) {
            self.marker = gizmo::place_in(rect, camera, light.marker(looked_at));
            has_moved = self.handles.show(ui, rect, camera, looked_at, light);
        }
        if has_moved {
            self.touch();
        }
    }

    /// Asks for truth once nothing moves, and takes what is there of it and of the sides' masks.
    fn measure(&mut self, ctx: &egui::Context) -> Result<()> {
        let Some(question) = question(self.camera, &self.settings, &self.stage) else {
            self.forget_figures();
            return Ok(());
        };
        let rests = self.rests();
        let (camera, lights) = (question.camera, &self.settings.lights);
        let ready = [0, 1].map(|i| {
            let side = &self.renderer.sides[i];
            rests && side.is_ready_for(&camera, lights, &self.settings.sides[i])
        });
        let (render, renderer) = (&self.render, &mut self.renderer);
        let is_new = self
            .figures
            .update(render, renderer, &question, rests, ready)?;
        if is_new {
            self.compare();
            // This frame was drawn before.
            ctx.request_repaint();
        }
        let awaits_times = rests && self.renderer.awaits_times();
        if self.figures.is_waiting() || awaits_times {
            ctx.request_repaint_after(Duration::from_millis(10));
        }
        Ok(())
    }

    /// Forgets what was measured and laid over the sides, since nothing can be measured.
    fn forget_figures(&mut self) {
        if self.figures.is_asked() {
            self.figures.forget();
            for overlay in &mut self.renderer.overlays {
                overlay.clear();
            }
        }
    }

    /// Compares masks with truth, and lays a picture of it over the sides.
    pub(crate) fn compare(&mut self) {
        let Some(question) = question(self.camera, &self.settings, &self.stage) else {
            return;
        };
        let shown = ShownFigures {
            picture: self.settings.picture,
            opacity: self.settings.opacity,
        };
        let techniques = self.settings.sides.each_ref();
        let (render, renderer) = (&self.render, &mut self.renderer);
        self.figures
            .compare(render, renderer, &question, techniques, &shown);
    }

    /// Begins to look for the least that the view needs.
    pub(crate) fn start_plan(&mut self, ctx: &egui::Context) {
        let Some(planned_for) = self.plan_wanted() else {
            self.message = Some("Choose a light that is on: plans are made for one.".to_owned());
            return;
        };
        let side = &self.renderer.sides[0];
        let refused = match side.refused_techniques(Kind::of(&planned_for.light)) {
            Ok(refused) => refused,
            Err(error) => {
                self.message = Some(format!("{error:#}"));
                return;
            }
        };
        self.refused.clone_from(&refused);
        let request = PlanRequest {
            geometry: self.stage.geometry.clone(),
            refused,
            planned_for: planned_for.clone(),
        };
        self.plan_asked = Some(planned_for);
        let wake = ctx.clone();
        self.plan_job.start(request, move || wake.request_repaint());
    }

    /// Returns what a plan would be made for now: the chosen light, as the whole picture shows it. None while that light is off.
    pub(crate) fn plan_wanted(&self) -> Option<PlannedFor> {
        let light = self.settings.lights.get(self.settings.chosen)?;
        light.is_on.then(|| PlannedFor {
            // A coarse picture's camera has fewer pixels while something moves.
            camera: self.camera_of_size(self.pixels),
            light: light.light,
            scene: self.stage.geometry.fingerprint(),
            error: f64::from(self.settings.plan_error),
            motion: self.settings.motion,
        })
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn tell(&mut self, ctx: &egui::Context) {
        // Taken out while it reads the rest.
        if let Some(mut told) = self.told.take() {
            if let Err(error) = told.update(self, ctx) {
                self.message = Some(format!("{error:#}"));
            }
            self.told = Some(told);
        }
    }

    /// Shows the setting that a plan found on the left.
    pub(crate) fn show_plan(&mut self) {
        let chosen = self
            .plan
            .as_ref()
            .and_then(|(plan, _)| plan.chosen.as_ref());
        let Some(preset) = chosen.map(|chosen| chosen.preset.clone()) else {
            self.message = Some("No setting was found yet: P looks for one.".to_owned());
            return;
        };
        self.settings.sides[0].take(&preset);
        self.forget_mask(0);
    }

    fn take_plan(&mut self) {
        match self.plan_job.take() {
            Some(Ok(plan)) => self.plan = self.plan_asked.take().map(|asked| (plan, asked)),
            Some(Err(error)) => self.message = Some(error),
            None => {}
        }
    }

    /// Forgets a side's mask, since its technique changed.
    pub(crate) fn forget_mask(&mut self, side: usize) {
        self.figures.forget_mask(side, &mut self.renderer);
        self.touch();
    }

    /// Asks for a picture of the window, which comes with one of the next frames.
    pub(crate) fn ask_for_screenshot(&self, ctx: &egui::Context) {
        let place = self.screenshot.clone();
        let wake = ctx.clone();
        ctx.request_screenshot(move |image| {
            *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(image);
            wake.request_repaint();
        });
    }

    fn save_screenshot(&mut self) {
        let image = self
            .screenshot
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(image) = image {
            self.message = Some(match panel::save_screenshot(&image) {
                Ok(place) => format!("The screenshot is in {place}."),
                Err(error) => format!("The screenshot can't be kept: {error:#}"),
            });
        }
    }

    fn time_frame(&mut self) -> Duration {
        let now = Instant::now();
        let passed = self.last_frame.map_or(Duration::ZERO, |last| now - last);
        self.last_frame = Some(now);
        // After a rest the time since the last frame says nothing.
        if self.was_moving {
            let old = self.times.interval;
            self.times.interval = if old.is_zero() {
                passed
            } else {
                old.mul_f32(0.7) + passed.mul_f32(0.3)
            };
        }
        passed
    }
}

/// Returns the share of the full width at which frames are as many a second as they should be, from what one took at another share. What a
/// frame takes goes with its pixels: with the square of the scale.
fn wanted_scale(scale: f32, took: Duration, frames_a_second: f32) -> f32 {
    let allowed = 1.0 / frames_a_second;
    let wanted = scale * (allowed / took.as_secs_f32().max(1e-3)).sqrt();
    wanted.clamp(COARSEST, 1.0)
}

/// Returns how many pixels of the window a part of it has, as the panel's painter places its edges.
fn pixels_of(rect: egui::Rect, pixels_per_point: f32) -> UVec2 {
    let between = |from: f32, to: f32| {
        let [from, to] = [from, to].map(|edge| (edge * pixels_per_point).round());
        (to - from).max(0.0) as u32
    };
    UVec2::new(
        between(rect.min.x, rect.max.x),
        between(rect.min.y, rect.max.y),
    )
}

/// Returns what is to be measured; none while the chosen light is off.
fn question<'a>(
    camera: Option<Camera>,
    settings: &Settings,
    stage: &'a Stage,
) -> Option<Question<'a>> {
    let chosen = settings.lights.get(settings.chosen)?;
    let before = &settings.lights[..settings.chosen];
    chosen.is_on.then_some(Question {
        camera: camera?,
        light: chosen.light,
        place: before.iter().filter(|light| light.is_on).count(),
        geometry: &stage.geometry,
    })
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        // A device that is lost says so now, before the panel's painter asks it for memory. What else is wrong the frame's passes say.
        let _ = self.render.device.poll(wgpu::PollType::Poll);
        if is_left(&self.lost) {
            if let Some(argument) = self.loader.argument() {
                put(&self.unfinished, argument);
            }
            // Nothing can be drawn any more: the window is opened again, with another device.
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        if let Some(fault) = taken(&self.fault) {
            self.message = Some(fault);
        }
        self.frames += 1;
        let passed = self.time_frame();
        self.take_files(&ctx);
        self.take_loaded(&ctx);
        self.keys(&ctx);
        zoom::update(&ctx, self.settings.zoom);
        self.save_screenshot();
        self.take_plan();
        let lights = self.settings.lights.clone();
        panel::show(self, ui);
        if lights != self.settings.lights {
            self.touch();
        }
        let frame = egui::Frame::NONE;
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            if let Err(error) = self.picture(ui, passed) {
                self.message = Some(format!("{error:#}"));
            }
            panel::over_picture(self, ui);
        });
        if let Err(error) = self.measure(&ctx) {
            self.message = Some(format!("{error:#}"));
        }
        #[cfg(not(target_arch = "wasm32"))]
        self.tell(&ctx);
        #[cfg(target_arch = "wasm32")]
        if !self.stage.is_nothing() {
            crate::web::note_frame();
        }
        if self.is_steered(&ctx) || self.changed.elapsed() < REST {
            ctx.request_repaint();
        } else if !self.figures.is_asked() {
            ctx.request_repaint_after(REST);
        }
        if self.loader.at().is_some() {
            // Its time is told; no more often, since frames take time from the loading.
            ctx.request_repaint_after(REST);
        }
    }

    /// Returns the panel's colour, as the window stores it. Painted by the panel's own shader, it took a fifth of the time of a large scene's
    /// frame on a software driver.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        if self.render.target_format.is_srgb() {
            egui::Rgba::from(visuals.panel_fill).to_array()
        } else {
            visuals.panel_fill.to_normalized_gamma_f32()
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if self.stage.is_nothing() {
            // What was kept stays.
            return;
        }
        match self.settings.saved(&self.stage) {
            Ok(saved) => eframe::set_value(storage, eframe::APP_KEY, &saved),
            Err(error) => log::warn!("the settings are not kept: {error:#}"),
        }
    }

    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_don_t_make_cards_coarser() {
        // Without a clock only the rate of frames is known, which may be the display's: 30, 50 or 60 a second.
        for passed in [33, 20, 17].map(Duration::from_millis) {
            assert_eq!(wanted_scale(1.0, passed, FLUENT_WITHOUT_CLOCK), 1.0);
        }
    }

    #[test]
    fn slow_frames_have_as_many_pixels_as_fit_into_their_time() {
        let of_card = |scale, took| wanted_scale(scale, Duration::from_millis(took), FLUENT);
        // Twice as long as there is time for: half of the pixels.
        assert!((of_card(1.0, 33) - 0.71).abs() < 0.01);
        // At the scale that it was drawn at, whatever the present one is.
        assert!((of_card(0.5, 33) - 0.355).abs() < 0.01);
        assert!((of_card(0.5, 5) - 0.91).abs() < 0.01);
        assert_eq!((of_card(1.0, 1), of_card(1.0, 10_000)), (1.0, COARSEST));
    }
}
