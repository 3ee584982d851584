//! State of the program.

use crate::{
    device::Slot,
    focus::Focus,
    gizmo::LightHandles,
    job::Job,
    lights::LightKind,
    loading::Loading,
    measure::{figures::ViewFigures, maps::MapPicture, subject::Subject},
    pace::Pace,
    path::MotionPath,
    picker::Picker,
    plan::{self, PlanRequest},
    render::{Renderer, present::Presenter},
    settings::{FirstShown, Settings},
    stage::ViewerScene,
};
use anyhow::{Context as _, Result};
use eframe::egui_wgpu::RenderState;
use std::sync::Arc;
use umbrage::{Camera, glam::UVec2, plan::Plan};

/// The default scene.
pub(crate) const FIRST_SCENE: &str = "town";
/// Width of windows below which the panel is initially folded, since it would cover the image:
/// pixels divided by the display's scale factor.
const NARROW: f32 = 700.0;

/// State of the program.
pub(crate) struct Viewer {
    pub render: RenderState,
    pub presenter: Presenter,
    pub stage: ViewerScene,
    pub renderer: Renderer,
    pub settings: Settings,
    /// Changes to the settings of the first scene, until it is shown.
    pub first_shown: Option<FirstShown>,
    /// The scene that is being loaded.
    pub loading: Option<Loading>,
    /// Motion of a failure.
    pub path: Option<MotionPath>,
    pub figures: ViewFigures,
    pub maps: [MapPicture; 2],
    /// The plan in progress, and its input.
    pub planning: Option<(Job<Plan>, PlanRequest)>,
    /// Techniques that the last plan excluded.
    pub refused: Vec<String>,
    /// The last plan, and its input.
    pub plan: Option<(Plan, PlanRequest)>,
    pub pace: Pace,
    /// Frames since the window was opened.
    pub frames: u64,
    /// Camera of the last frame. Its size is smaller than the image's while something moves and
    /// frames take long.
    pub camera: Option<Camera>,
    /// Size of the image in the window, pixels.
    pub pixels: UVec2,
    pub handles: LightHandles,
    /// Position of the selected light's marker in the window, points.
    pub marker: Option<egui::Pos2>,
    /// Steps ahead requested since the last frame.
    pub steps_nearer: f32,
    pub message: Option<String>,
    /// The open list for choosing with the keyboard.
    pub picker: Option<Picker>,
    pub focus: Focus,
    pub screenshot: Slot<Arc<egui::ColorImage>>,
}

impl Viewer {
    /// Returns the state of a window without a scene.
    ///
    /// # Errors
    /// Returns an error if the device can't be used.
    pub(crate) fn new(render: RenderState, settings: Settings) -> Result<Self> {
        let stage = ViewerScene::nothing();
        let renderer = Renderer::new(&render.device, &render.queue, &stage, &settings)?;
        Ok(Self {
            presenter: Presenter::new(&render.device, render.target_format),
            render,
            stage,
            renderer,
            settings,
            first_shown: None,
            loading: None,
            path: None,
            figures: ViewFigures::default(),
            maps: Default::default(),
            planning: None,
            refused: Vec::new(),
            plan: None,
            pace: Pace::default(),
            frames: 0,
            camera: None,
            pixels: UVec2::ONE,
            handles: LightHandles::default(),
            marker: None,
            steps_nearer: 0.0,
            message: None,
            picker: None,
            focus: Focus::default(),
            screenshot: Slot::default(),
        })
    }

    /// Shows an error as a message. Returns the value if there is one.
    pub(crate) fn check<T>(&mut self, result: Result<T>) -> Option<T> {
        result
            .map_err(|error| self.message = Some(format!("{error:#}")))
            .ok()
    }

    /// Returns a camera's view of the selected light. `None` while that is off.
    fn subject_of(&self, camera: Camera) -> Option<Subject> {
        let light = self.settings.lights.get(self.settings.chosen)?;
        light.is_on.then(|| Subject {
            camera,
            light: light.light,
            geometry: self.stage.geometry.clone(),
            casters: self.renderer.sides[0].set.casters_box(),
        })
    }

    /// Returns the measured subject: the last frame and the selected light. `None` while that is
    /// off.
    pub(crate) fn subject(&self) -> Option<Subject> {
        self.subject_of(self.camera?)
    }

    /// Returns the current camera for an image of this size, pixels. It may be on a path.
    pub(crate) fn camera_of_size(&self, size: UVec2) -> Camera {
        let camera = self.settings.view.camera(size);
        match &self.path {
            Some(path) => path.camera(&camera),
            None => camera,
        }
    }

    /// Starts measurements at rest, and receives figures.
    pub(crate) fn measure(&mut self, ctx: &egui::Context) -> Result<()> {
        let Some(subject) = self.subject() else {
            self.figures.forget(&mut self.renderer);
            return Ok(());
        };
        let rests = self.pace.rests();
        let (renderer, settings) = (&mut self.renderer, &self.settings);
        let is_new = self
            .figures
            .update(ctx, renderer, settings, &subject, rests)?;
        if is_new {
            self.compare(ctx);
            // Draw another frame with the new figures.
            ctx.request_repaint();
        }
        if self.figures.is_waiting() || rests && self.renderer.awaits_times() {
            ctx.request_repaint_after(std::time::Duration::from_millis(10));
        }
        Ok(())
    }

    /// Compares masks with the reference, and updates the overlays of the sides.
    pub(crate) fn compare(&mut self, ctx: &egui::Context) {
        self.figures
            .compare(ctx, &mut self.renderer, &self.settings);
    }

    /// Discards a side's figures, since its technique changed.
    pub(crate) fn forget_side(&mut self, side: usize) {
        self.figures.forget_side(side, &mut self.renderer);
        self.pace.touch();
    }

    /// Copies a side's settings for the selected light in the format of preset files.
    pub(crate) fn copy_preset(&mut self, ctx: &egui::Context, side: usize) {
        let Some(light) = self.settings.lights.get(self.settings.chosen) else {
            return;
        };
        let text = self.settings.sides[side].preset_text(&light.light);
        if let Some(text) = self.check(text) {
            ctx.copy_text(text);
            self.message = Some("The preset is in the clipboard.".to_owned());
        }
    }

    /// Returns the input of a plan for the whole image and the selected light. `None` while that is
    /// off.
    pub(crate) fn plan_request(&self) -> Option<PlanRequest> {
        Some(PlanRequest {
            // Use the full size, since the last frame may have fewer pixels during motion.
            subject: self.subject_of(self.camera_of_size(self.pixels))?,
            error: f64::from(self.settings.plan_error()),
            motion: self.settings.motion,
        })
    }

    /// Starts to search for the cheapest technique.
    pub(crate) fn start_plan(&mut self, ctx: &egui::Context) {
        let planning = self.try_to_plan(ctx);
        self.planning = self.check(planning);
    }

    fn try_to_plan(&mut self, ctx: &egui::Context) -> Result<(Job<Plan>, PlanRequest)> {
        let request = self.plan_request();
        let request = request.context("Select a light that is on: a plan is for one light.")?;
        let kind = LightKind::of_light(&request.subject.light);
        self.refused = self.renderer.sides[0].refused_techniques(kind)?;
        Ok((plan::start(ctx, &request, &self.refused)?, request))
    }

    /// Receives a finished plan.
    pub(crate) fn take_plan(&mut self) {
        let Some((job, _)) = &mut self.planning else {
            return;
        };
        let Some(outcome) = job.take() else {
            return;
        };
        let request = self.planning.take().map(|(_, request)| request);
        let plan = self.check(outcome.context("The plan failed"));
        self.plan = plan.zip(request).or_else(|| self.plan.take());
    }

    /// Shows the settings of the plan on the left.
    pub(crate) fn show_plan(&mut self) {
        let plan = self.plan.as_ref();
        match plan.and_then(|(plan, _)| plan.chosen.as_ref()) {
            Some(chosen) => {
                self.settings.sides[0].take(&chosen.preset);
                self.forget_side(0);
            }
            None => {
                self.message = Some("There is no plan yet. Press P to search for one.".to_owned());
            }
        }
    }

    /// Reports whether the panel is folded. By default, that depends on the window's width.
    pub(crate) fn is_folded(&self, ctx: &egui::Context) -> bool {
        let chosen = self.settings.panel_is_folded;
        chosen.unwrap_or_else(|| is_narrow(ctx))
    }

    /// Folds the panel, or unfolds it.
    pub(crate) fn fold(&mut self, ctx: &egui::Context) {
        self.settings.panel_is_folded = Some(!self.is_folded(ctx));
    }

    /// Requests an image of the window, which arrives with one of the next frames.
    pub(crate) fn request_screenshot(&self, ctx: &egui::Context) {
        let slot = self.screenshot.clone();
        let wake = ctx.clone();
        ctx.request_screenshot(move |image| {
            slot.put(image);
            wake.request_repaint();
        });
    }

    /// Saves a requested screenshot.
    pub(crate) fn save_screenshot(&mut self) {
        let Some(image) = self.screenshot.take() else {
            return;
        };
        let saved = save_image(&image).context("The screenshot can't be saved");
        if let Some(file) = self.check(saved) {
            self.message = Some(format!("The screenshot is in {file}."));
        }
    }
}

/// Reports whether the window is narrow.
pub(crate) fn is_narrow(ctx: &egui::Context) -> bool {
    ctx.viewport_rect().width() * ctx.zoom_factor() < NARROW
}

/// Writes an image. Returns the file's name.
#[cfg(not(target_arch = "wasm32"))]
fn save_image(image: &egui::ColorImage) -> Result<String> {
    let seconds = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |since| since.as_secs());
    let file = std::env::current_dir()?.join(format!("umbrage-{seconds}.png"));
    let [width, height] = image.size.map(|side| side as u32);
    let image = image::RgbaImage::from_raw(width, height, image.as_raw().to_vec());
    image
        .context("the window returned a broken picture")?
        .save(&file)?;
    Ok(file.display().to_string())
}

/// Returns an error, since browsers have no folders.
#[cfg(target_arch = "wasm32")]
fn save_image(_: &egui::ColorImage) -> Result<String> {
    anyhow::bail!("take the browser's own screenshot")
}
