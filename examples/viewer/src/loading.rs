//! Scenes and models are read beside the window, which never waits: the scene that is shown stays until the new one has been read,
//! placed, uploaded, and drawn once.
//!
//! On the desktop a thread does all of it. In browsers a worker reads and places; uploading and the first frame are left to the page.

#[cfg(not(target_arch = "wasm32"))]
mod thread;

#[cfg(target_arch = "wasm32")]
pub(crate) use crate::web::Loader;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use thread::Loader;

use crate::{
    app::{App, FIRST_SCENE},
    bookmarks::{self, Bookmark},
    drops::scene_among,
    path::MotionPath,
    render::{FrameSettings, Renderer, Shown},
    stage::Stage,
    state::{SceneAsLeft, Settings},
};
use anyhow::Result;
use umbrage::glam::UVec2;

/// What follows once a scene is there.
#[derive(Clone)]
pub(crate) enum Then {
    /// It is shown as it is.
    Show,
    /// It is shown as it was left the last time.
    AsLeft(SceneAsLeft),
    /// The fault on the left, the cure on the right.
    Compare(Bookmark),
}

/// Where a scene comes from.
pub(crate) enum Source {
    /// A built-in scene's name, or a file.
    Argument(String),
    /// Files that were dropped on the page; the first is the scene.
    #[cfg(target_arch = "wasm32")]
    Files(Vec<egui::DroppedFileHandle>),
}

/// What is asked for.
pub(crate) struct Request {
    pub name: String,
    pub source: Source,
    pub then: Then,
    /// Those of the window when it was asked: the first frame is drawn with them.
    settings: Settings,
    /// Size of the picture, pixels.
    size: UVec2,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// A scene that is there.
pub(crate) struct Loaded {
    stage: Stage,
    renderer: Renderer,
    path: Option<MotionPath>,
    /// What else the user should know.
    note: Option<String>,
}

/// What came of a request.
pub(crate) struct Outcome {
    pub name: String,
    pub then: Then,
    pub loaded: Result<Loaded>,
}

/// Says what is done next, in words; false once the scene is not wanted any more.
pub(crate) type GoesOn<'a> = &'a dyn Fn(String) -> bool;

/// Returns what is said while the stage goes to the device.
pub(crate) fn going_to_device(stage: &Stage) -> String {
    let count = stage.geometry.triangles().len();
    format!("{count} triangles go to the device")
}

impl Request {
    /// Uploads a stage, and draws it for the first time; none if it was given up.
    ///
    /// # Errors
    /// Errors if the device can't hold it.
    pub(crate) fn prepared(self, stage: Stage, goes_on: GoesOn<'_>) -> Result<Option<Loaded>> {
        if !goes_on(going_to_device(&stage)) {
            return Ok(None);
        }
        let mut settings = self.settings;
        settings.show(&stage);
        self.then.apply(&mut settings, &stage);
        let sides = settings.sides.each_ref();
        let mut renderer = Renderer::new(&self.device, &self.queue, &stage, sides)?;
        let count = stage.geometry.triangles().len();
        if !goes_on(format!("{count} triangles are drawn for the first time")) {
            return Ok(None);
        }
        let camera = settings.view.camera(self.size.max(UVec2::splat(16)));
        let frame = FrameSettings {
            camera: &camera,
            stage: &stage,
            lights: &settings.lights,
            sides,
            shown: Shown::Both(0.5),
            is_coarse: false,
            prepares_both: true,
        };
        // The first frame makes pipelines, maps and lists: the window's own first one finds them. What is wrong with it that one says, too.
        if let Err(error) = renderer.frame(&frame) {
            log::warn!("{}: {error:#}", self.name);
        }
        let path = match self.then {
            Then::Compare(bookmark) => bookmark.moving(),
            Then::Show | Then::AsLeft(_) => None,
        };
        let path = path
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

#[cfg(target_arch = "wasm32")]
impl Loaded {
    pub(crate) fn with_note(self, note: Option<String>) -> Self {
        Self { note, ..self }
    }
}

impl Then {
    /// Brings settings that show the stage to what is wanted beyond that.
    fn apply(&self, settings: &mut Settings, stage: &Stage) {
        match self {
            Self::Show => {}
            Self::AsLeft(left) => left.apply(settings),
            Self::Compare(bookmark) => {
                let range = settings.sides[0].range;
                let light = stage.lights.first();
                settings.sides = [bookmark.fault(range), bookmark.cure(light, range)];
                settings.split = Some(0.5);
            }
        }
    }
}

/// Returns what names the same scene when the program is started in another folder: built-in scenes are named as they are, files with all
/// their folders.
#[cfg(not(target_arch = "wasm32"))]
fn anywhere(argument: &str) -> String {
    let is_built_in = umbrage::scenes::find(argument).is_some();
    match std::path::absolute(argument) {
        Ok(path) if !is_built_in => path.display().to_string(),
        _ => argument.to_owned(),
    }
}

/// Whether two arguments name the same scene: the same name, or the same file by whatever path.
pub(crate) fn are_same_scene(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(anywhere);
    // Files by their paths without links and `..`; browsers have none.
    let file = |path: &str| std::fs::canonicalize(path).ok();
    a == b || file(&a).is_some_and(|of_a| file(&b) == Some(of_a))
}

/// Browsers have no folders.
#[cfg(target_arch = "wasm32")]
fn anywhere(argument: &str) -> String {
    argument.to_owned()
}

impl App {
    /// Begins to read another scene; one that is being read is given up. The present one stays until then, and for good if the other can't
    /// be shown: a message says why.
    pub(crate) fn open(&mut self, ctx: &egui::Context, argument: &str, then: Then) {
        self.load(ctx, argument, Source::Argument(anywhere(argument)), then);
    }

    fn load(&mut self, ctx: &egui::Context, name: &str, source: Source, then: Then) {
        self.message = None;
        let request = Request {
            name: name.to_owned(),
            source,
            then,
            settings: self.settings.clone(),
            size: self.camera.map_or(UVec2::ZERO, |camera| camera.size),
            device: self.render.device.clone(),
            queue: self.render.queue.clone(),
        };
        let wake = ctx.clone();
        self.loader.start(request, move || wake.request_repaint());
    }

    /// Gives up what is being read; the present scene stays.
    pub(crate) fn give_up_loading(&mut self) {
        self.loader.cancel();
        if self.stage.is_nothing() {
            self.message = Some("F2 chooses a scene or a file.".to_owned());
        }
    }

    /// Shows what has been read since the last frame.
    pub(crate) fn take_loaded(&mut self, ctx: &egui::Context) {
        let Some(Outcome { name, then, loaded }) = self.loader.take() else {
            return;
        };
        match loaded {
            Ok(Loaded {
                stage,
                renderer,
                path,
                note,
            }) => {
                self.settings.show(&stage);
                then.apply(&mut self.settings, &stage);
                if let Some(first) = self.first_shown.take() {
                    first.apply(&mut self.settings);
                }
                self.stage = stage;
                // The overlays go with the old renderer.
                self.renderer = renderer;
                self.path = path;
                self.figures.forget();
                // It was of the old scene.
                self.plan_job.cancel();
                self.plan = None;
                self.message = note.or_else(|| self.message.take());
                self.touch();
            }
            Err(error) => {
                self.first_shown = None;
                if self.stage.is_nothing() && name != FIRST_SCENE {
                    self.open(ctx, FIRST_SCENE, Then::Show);
                }
                let error = format!("{error:#}");
                // Errors of files begin with them.
                let names_it = error.contains(&name);
                self.message = Some(if names_it {
                    error
                } else {
                    format!("{name}: {error}")
                });
            }
        }
    }

    /// Takes files that were dropped on the window or the page. On the desktop, what a scene names is read from its folder, dropped or not.
    pub(crate) fn take_files(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        let paths: Vec<_> = files.iter().map(|file| file.path().to_owned()).collect();
        if paths.is_empty() {
            return;
        }
        let (first, note) = scene_among(&paths);
        let name = paths[first].display().to_string();
        #[cfg(not(target_arch = "wasm32"))]
        self.open(ctx, &name, Then::Show);
        #[cfg(target_arch = "wasm32")]
        {
            let mut files = files;
            files.swap(0, first);
            self.load(ctx, &name, Source::Files(files), Then::Show);
        }
        self.message = note;
    }
}
