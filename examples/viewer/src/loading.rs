//! Scenes and models are loaded in the background. The current scene stays visible until the new
//! one has been read, placed, uploaded, and drawn once.
//!
//! On the desktop, a thread does all of it. In browsers, a worker reads and places; the page
//! uploads and draws the first frame.

use crate::{
    bookmarks::{self, Bookmark},
    job::Job,
    path::MotionPath,
    render::{FrameSettings, Renderer},
    settings::Settings,
    stage::{OnStep, ViewerScene},
};
use anyhow::Result;
use umbrage::glam::UVec2;
use web_time::Instant;

/// Actions after a scene is loaded.
#[derive(Clone)]
pub(crate) enum Then {
    /// Show the scene.
    Show,
    /// Show the scene with these previous settings.
    AsLeft(Box<Settings>),
    /// Show the artefact on the left side, and its fix on the right.
    Compare(Bookmark),
}

/// Source of a scene.
#[derive(Clone)]
pub(crate) enum SceneSource {
    /// Name of a built-in scene, or path of a file.
    Argument(String),
    /// Files dropped on the page. The first is the scene.
    #[cfg(target_arch = "wasm32")]
    Files(Vec<egui::DroppedFileHandle>),
}

/// Input of loading.
#[derive(Clone)]
pub(crate) struct Request {
    pub name: String,
    pub source: SceneSource,
    pub then: Then,
    /// The window's settings at the time of the request. The first frame uses them.
    pub settings: Settings,
    /// Size of the image, pixels.
    pub size: UVec2,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

/// A loaded scene.
pub(crate) struct Loaded {
    pub stage: ViewerScene,
    pub renderer: Renderer,
    pub path: Option<MotionPath>,
    /// Message for the user.
    pub note: Option<String>,
}

/// A scene that is being loaded. Dropping it cancels loading.
pub(crate) struct Loading {
    pub request: Request,
    begun: Instant,
    #[cfg(not(target_arch = "wasm32"))]
    job: Job<Loaded>,
    #[cfg(target_arch = "wasm32")]
    job: Job<crate::web::scenes::MadeStage>,
    /// Result of the worker, until the next frame uploads it.
    #[cfg(target_arch = "wasm32")]
    made: Option<Result<crate::web::scenes::MadeStage>>,
}

impl Loading {
    pub(crate) fn start(ctx: &egui::Context, request: Request) -> Self {
        Self {
            #[cfg(not(target_arch = "wasm32"))]
            job: {
                let request = request.clone();
                Job::start(ctx, move |progress| {
                    let on_step: OnStep<'_> = &|step| progress.step(step);
                    let SceneSource::Argument(argument) = &request.source;
                    match ViewerScene::of_argument(argument, on_step)? {
                        Some(stage) => request.prepare(stage, on_step),
                        None => Ok(None),
                    }
                })
            },
            #[cfg(target_arch = "wasm32")]
            job: crate::web::scenes::start(ctx, &request.source),
            #[cfg(target_arch = "wasm32")]
            made: None,
            request,
            begun: Instant::now(),
        }
    }

    /// Returns the name of the scene and a description of the current step.
    pub(crate) fn label(&self) -> String {
        let seconds = self.begun.elapsed().as_secs();
        format!("{}: {} ({seconds} s)", self.request.name, self.job.step())
    }

    /// Returns the built-in scene or the file that is being loaded.
    pub(crate) fn argument(&self) -> Option<&str> {
        match &self.request.source {
            SceneSource::Argument(argument) => Some(argument),
            #[cfg(target_arch = "wasm32")]
            SceneSource::Files(_) => None,
        }
    }

    /// Returns the outcome when it is available.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn take(&mut self) -> Option<Result<Loaded>> {
        self.job.take()
    }

    /// Returns the outcome when it is available. The upload follows in the call after the worker's
    /// end, so that a frame can report it first: the page doesn't respond meanwhile.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn take(&mut self) -> Option<Result<Loaded>> {
        if let Some(made) = self.made.take() {
            return Some(made.and_then(|made| {
                let note = made.note(&self.request.name);
                let loaded = self.request.prepare(made.stage, &|_| true)?;
                let loaded = loaded.ok_or_else(|| anyhow::anyhow!("it was cancelled"))?;
                Ok(Loaded { note, ..loaded })
            }));
        }
        let made = self.job.take()?;
        if let Ok(made) = &made {
            self.job.set_step(upload_label(&made.stage));
        }
        self.made = Some(made);
        None
    }
}

fn upload_label(stage: &ViewerScene) -> String {
    let count = stage.geometry.triangles().len();
    format!("{count} triangles go to the device")
}

impl Request {
    /// Uploads a stage, and draws it for the first time. Returns `None` if it was cancelled.
    ///
    /// # Errors
    /// Returns an error if the device can't hold it.
    fn prepare(&self, stage: ViewerScene, on_step: OnStep<'_>) -> Result<Option<Loaded>> {
        if !on_step(upload_label(&stage)) {
            return Ok(None);
        }
        let mut settings = self.settings.clone();
        settings.show(&stage);
        self.then.apply(&mut settings, &stage);
        let mut renderer = Renderer::new(&self.device, &self.queue, &stage, &settings)?;
        let count = stage.geometry.triangles().len();
        if !on_step(format!("drawing {count} triangles for the first time")) {
            return Ok(None);
        }
        settings.split = Some(0.5);
        let camera = settings.view.camera(self.size.max(UVec2::splat(16)));
        let frame = FrameSettings {
            camera: &camera,
            stage: &stage,
            settings: &settings,
            is_moving: false,
            is_coarse: false,
        };
        // Draw a frame to create pipelines, maps and lists for the window's first frame, which
        // reports errors, too.
        if let Err(error) = renderer.frame(&frame) {
            log::warn!("{}: {error:#}", self.name);
        }
        let moving = match self.then {
            Then::Compare(bookmark) => bookmark.moving_scene(),
            Then::Show | Then::AsLeft(_) => None,
        };
        let path = moving
            .map(|moving| MotionPath::new(moving, &stage, &settings.view, bookmarks::COARSE))
            .transpose()?;
        Ok(Some(Loaded {
            stage,
            renderer,
            path,
            note: None,
        }))
    }
}

impl Then {
    /// Changes settings that show the stage.
    pub(crate) fn apply(&self, settings: &mut Settings, stage: &ViewerScene) {
        match self {
            Self::Show => {}
            Self::AsLeft(left) => settings.show_as_left(left),
            Self::Compare(bookmark) => {
                let range = settings.sides[0].range;
                let light = stage.lights.first();
                settings.sides = [bookmark.fault(range), bookmark.fix(light, range)];
                settings.split = Some(0.5);
            }
        }
    }
}

/// Returns an argument that is valid in any folder. Built-in scenes keep their names, and files
/// receive absolute paths.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn absolute(argument: &str) -> String {
    let is_built_in = umbrage::scenes::find(argument).is_some();
    match std::path::absolute(argument) {
        Ok(path) if !is_built_in => path.display().to_string(),
        _ => argument.to_owned(),
    }
}

/// Returns the argument, since browsers have no folders.
#[cfg(target_arch = "wasm32")]
pub(crate) fn absolute(argument: &str) -> String {
    argument.to_owned()
}

/// Reports whether two arguments have the same name, or paths of the same file.
pub(crate) fn are_same_scene(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(absolute);
    // Compare paths without links and `..`. Browsers have none.
    let file = |path: &str| std::fs::canonicalize(path).ok();
    a == b || file(&a).is_some_and(|of_a| file(&b) == Some(of_a))
}
