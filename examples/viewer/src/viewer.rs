//! State of the program.

use crate::{
    device::Slot,
    focus::Focus,
    gizmo::LightHandles,
    job::Job,
    lights::Kind,
    loading::Loading,
    measure::{figures::ViewFigures, maps::MapPicture, subject::Subject},
    pace::Pace,
    path::MotionPath,
    picker::Picker,
    plan::{self, PlanRequest},
    render::{Renderer, present::Presenter},
    settings::{FirstShown, Settings},
    stage::Stage,
};
use anyhow::{Context as _, Result};
use eframe::egui_wgpu::RenderState;
use std::sync::Arc;
use umbrage::{Camera, glam::UVec2, plan::Plan};

/// The scene that is shown if the user names none.
pub(crate) const FIRST_SCENE: &str = "town";
/// Windows less wide than this begin with the panel folded, since it would cover the picture:
/// pixels divided by the display's scale factor.
const NARROW: f32 = 700.0;

/// State of the program.
pub(crate) struct Viewer {
    pub render: RenderState,
    pub presenter: Presenter,
    pub stage: Stage,
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
    /// The plan that is being made, and its input.
    pub planning: Option<(Job<Plan>, PlanRequest)>,
    /// Techniques that the last plan left out.
    pub refused: Vec<String>,
    /// The last plan, and its input.
    pub plan: Option<(Plan, PlanRequest)>,
    pub pace: Pace,
    /// Frames since the window was opened.
    pub frames: u64,
    /// Camera of the last frame. Its size is smaller than the picture's while something moves and
    /// frames take long.
    pub camera: Option<Camera>,
    /// Size of the picture in the window, pixels.
    pub pixels: UVec2,
    pub handles: LightHandles,
    /// Position of the chosen light's marker in the window, points.
    pub marker: Option<egui::Pos2>,
    /// Steps ahead that were requested since the last frame.
    pub steps_nearer: f32,
    pub message: Option<String>,
    /// The list from which the keyboard chooses, while it is open.
    pub picker: Option<Picker>,
    pub focus: Focus,
    pub screenshot: Slot<Arc<egui::ColorImage>>,
}

impl Viewer {
    /// Returns the state of a window without a scene.
    ///
    /// # Errors
    /// Errors if the device can't be used.
    pub(crate) fn new(render: RenderState, settings: Settings) -> Result<Self> {
        let stage = Stage::nothing();
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

    /// Returns what a camera sees of the chosen light; `None` while that is off.
    fn subject_of(&self, camera: Camera) -> Option<Subject> {
        let light = self.settings.lights.get(self.settings.chosen)?;
        light.is_on.then(|| Subject {
            camera,
            light: light.light,
            geometry: self.stage.geometry.clone(),
            casters: self.renderer.sides[0].set.casters_box(),
        })
    }

    /// Returns what is measured: the last frame and the chosen light; `None` while that is off.
    pub(crate) fn subject(&self) -> Option<Subject> {
        self.subject_of(self.camera?)
    }

    /// Returns the current camera for a picture of this size, pixels. It may be on a path.
    pub(crate) fn camera_of_size(&self, size: UVec2) -> Camera {
        let camera = self.settings.view.camera(size);
        match &self.path {
            Some(path) => path.camera(&camera),
            None => camera,
        }
    }

    /// Starts to measure once nothing moves, and takes figures.
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
            // This frame was drawn before.
            ctx.request_repaint();
        }
        if self.figures.is_waiting() || rests && self.renderer.awaits_times() {
            ctx.request_repaint_after(std::time::Duration::from_millis(10));
        }
        Ok(())
    }

    /// Compares masks with truth, and lays pictures over the sides.
    pub(crate) fn compare(&mut self, ctx: &egui::Context) {
        self.figures
            .compare(ctx, &mut self.renderer, &self.settings);
    }

    /// Forgets a side's figures, since its technique changed.
    pub(crate) fn forget_side(&mut self, side: usize) {
        self.figures.forget_side(side, &mut self.renderer);
        self.pace.touch();
    }

    /// Copies a side's settings for the chosen light, as a preset file has them.
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

    /// Returns the input of a plan for the whole picture and the chosen light; `None` while that is
    /// off.
    pub(crate) fn plan_request(&self) -> Option<PlanRequest> {
        Some(PlanRequest {
            // While something moves, the last frame may have fewer pixels.
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
        let request = request.context("Choose a light that is on: plans are made for one.")?;
        let kind = Kind::of(&request.subject.light);
        self.refused = self.renderer.sides[0].refused_techniques(kind)?;
        Ok((plan::start(ctx, &request, &self.refused)?, request))
    }

    /// Takes a plan that is finished.
    pub(crate) fn take_plan(&mut self) {
        let Some((job, _)) = &mut self.planning else {
            return;
        };
        let Some(outcome) = job.take() else {
            return;
        };
        let request = self.planning.take().map(|(_, request)| request);
        let plan = self.check(outcome.context("No plan was made"));
        self.plan = plan.zip(request).or_else(|| self.plan.take());
    }

    /// Shows the setting of the plan on the left.
    pub(crate) fn show_plan(&mut self) {
        let plan = self.plan.as_ref();
        match plan.and_then(|(plan, _)| plan.chosen.as_ref()) {
            Some(chosen) => {
                self.settings.sides[0].take(&chosen.preset);
                self.forget_side(0);
            }
            None => {
                self.message = Some("No setting was found yet: P looks for one.".to_owned());
            }
        }
    }

    /// Returns whether the panel is folded. Until the user chooses, that depends on the window's
    /// width.
    pub(crate) fn is_folded(&self, ctx: &egui::Context) -> bool {
        let chosen = self.settings.panel_is_folded;
        chosen.unwrap_or_else(|| is_narrow(ctx))
    }

    /// Folds the panel, or unfolds it.
    pub(crate) fn fold(&mut self, ctx: &egui::Context) {
        self.settings.panel_is_folded = Some(!self.is_folded(ctx));
    }

    /// Requests a picture of the window, which comes with one of the next frames.
    pub(crate) fn request_screenshot(&self, ctx: &egui::Context) {
        let slot = self.screenshot.clone();
        let wake = ctx.clone();
        ctx.request_screenshot(move |image| {
            slot.put(image);
            wake.request_repaint();
        });
    }

    /// Saves a screenshot that was requested.
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

/// Returns whether the window is narrow.
pub(crate) fn is_narrow(ctx: &egui::Context) -> bool {
    ctx.viewport_rect().width() * ctx.zoom_factor() < NARROW
}

/// Writes an image. Returns the file.
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

/// Browsers have no folders.
#[cfg(target_arch = "wasm32")]
fn save_image(_: &egui::ColorImage) -> Result<String> {
    anyhow::bail!("take the browser's own screenshot")
}
