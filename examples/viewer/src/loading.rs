//! Scenes and models are read on a thread of their own, so that the window never waits: the scene that is shown stays until the new one
//! has been read, placed, uploaded, and drawn once.
//!
//! Browsers have no threads here: there the page stands still meanwhile.

#[cfg(not(target_arch = "wasm32"))]
use crate::drops::scene_among;
use crate::{
    app::{App, FIRST_SCENE},
    bookmarks,
    camera::ViewCamera,
    render::{FrameSettings, Renderer, Shown},
    stage::Stage,
    state::Settings,
};
use anyhow::Result;
use std::{
    panic::{self, AssertUnwindSafe},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};
use umbrage::{glam::UVec2, scenes::Failure};
use web_time::Instant;

/// What follows once a scene is there.
#[derive(Clone, Copy)]
pub(crate) enum Then {
    /// It is shown as it is.
    Show,
    /// It is seen from where it was seen the last time.
    SeeFrom(ViewCamera),
    /// The fault on the left, the cure on the right.
    Compare(Failure),
}

/// Where a scene comes from.
pub(crate) enum Source {
    /// A built-in scene's name, or a file.
    Argument(String),
    /// A browser has read it.
    #[cfg(target_arch = "wasm32")]
    Read(Result<Stage>),
}

/// A scene that is there.
struct Loaded {
    stage: Stage,
    renderer: Renderer,
}

/// What is asked for.
struct Request {
    source: Source,
    then: Then,
    /// Those of the window when it was asked: the first frame is drawn with them.
    settings: Settings,
    /// Size of the picture, pixels.
    size: UVec2,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// A scene that is being read.
struct Job {
    name: String,
    then: Then,
    begun: Instant,
    is_given_up: AtomicBool,
    shared: Mutex<Shared>,
}

#[derive(Default)]
struct Shared {
    /// What is being done, in words.
    at: String,
    outcome: Option<Result<Loaded>>,
}

/// Reads one scene at a time; a newer one replaces it.
#[derive(Default)]
pub(crate) struct Loader {
    job: Option<Arc<Job>>,
}

fn locked(job: &Job) -> MutexGuard<'_, Shared> {
    job.shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Loader {
    fn start(&mut self, name: String, request: Request, wake: impl Fn() + Send + 'static) {
        self.cancel();
        let job = Arc::new(Job {
            name,
            then: request.then,
            begun: Instant::now(),
            is_given_up: AtomicBool::new(false),
            shared: Mutex::default(),
        });
        self.job = Some(job.clone());
        let play = move || {
            // A panic would leave the window waiting for ever.
            let played = panic::catch_unwind(AssertUnwindSafe(|| load(request, &job)));
            let outcome = played.unwrap_or_else(|_| {
                Err(anyhow::anyhow!(
                    "reading it hit an error of this program; please report it, with the file"
                ))
            });
            locked(&job).outcome = outcome.transpose();
            wake();
        };
        #[cfg(not(target_arch = "wasm32"))]
        std::thread::spawn(play);
        #[cfg(target_arch = "wasm32")]
        play();
    }

    /// Gives up what is being read. The thread ends with the step that it is at.
    pub(crate) fn cancel(&mut self) {
        if let Some(job) = self.job.take() {
            job.is_given_up.store(true, Ordering::Release);
        }
    }

    /// What is being read, and what is done with it, in words; none while nothing is.
    pub(crate) fn at(&self) -> Option<String> {
        let job = self.job.as_ref()?;
        let seconds = job.begun.elapsed().as_secs();
        Some(format!("{}: {} ({seconds} s)", job.name, locked(job).at))
    }

    /// Returns what has been read since it was asked last: its name, what follows, and the scene.
    fn take(&mut self) -> Option<(String, Then, Result<Loaded>)> {
        let job = self.job.as_ref()?;
        let outcome = locked(job).outcome.take()?;
        let (name, then) = (job.name.clone(), job.then);
        self.job = None;
        Some((name, then, outcome))
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Reads and prepares a scene; none if it was given up.
fn load(request: Request, job: &Job) -> Result<Option<Loaded>> {
    let goes_on = |at: String| {
        locked(job).at = at;
        !job.is_given_up.load(Ordering::Acquire)
    };
    let stage = match request.source {
        Source::Argument(argument) => {
            goes_on("is read".to_owned());
            // Errors of scenes hold what they come from in their own words: `anyhow` is given the words alone, else it would repeat it.
            let scene = umbrage::scenes::by_argument(&argument).map_err(anyhow::Error::msg)?;
            if !goes_on("its triangles are placed".to_owned()) {
                return Ok(None);
            }
            Stage::of_scene(&argument, &argument, scene)?
        }
        #[cfg(target_arch = "wasm32")]
        Source::Read(stage) => stage?,
    };
    let count = stage.geometry.triangles().len();
    if !goes_on(format!("{count} triangles go to the device")) {
        return Ok(None);
    }
    let mut settings = request.settings;
    settings.show(&stage);
    request.then.apply(&mut settings, &stage);
    let sides = settings.sides.each_ref();
    let mut renderer = Renderer::new(&request.device, &request.queue, &stage, sides)?;
    if !goes_on(format!("{count} triangles are drawn for the first time")) {
        return Ok(None);
    }
    let camera = settings.view.camera(request.size.max(UVec2::splat(16)));
    let frame = FrameSettings {
        camera: &camera,
        stage: &stage,
        lights: &settings.lights,
        sides,
        shown: Shown::Both(0.5),
        prepares_both: true,
    };
    // The first frame makes pipelines, maps and lists: the window's own first one finds them. What is wrong with it that one says, too.
    if let Err(error) = renderer.frame(&frame) {
        log::warn!("{}: {error:#}", job.name);
    }
    Ok(Some(Loaded { stage, renderer }))
}

impl Then {
    /// Brings settings that show the stage to what is wanted beyond that.
    fn apply(self, settings: &mut Settings, stage: &Stage) {
        match self {
            Self::Show => {}
            Self::SeeFrom(view) => settings.view = view,
            Self::Compare(failure) => {
                let range = settings.sides[0].range;
                let light = stage.lights.first();
                settings.sides = [
                    bookmarks::fault(failure, range),
                    bookmarks::cure(light, range),
                ];
                settings.split = Some(0.5);
            }
        }
    }
}

impl App {
    /// Begins to read another scene; one that is being read is given up. The present one stays until then, and for good if the other can't
    /// be shown: a message says why.
    pub(crate) fn open(&mut self, ctx: &egui::Context, argument: &str, then: Then) {
        self.message = None;
        self.load(ctx, argument, Source::Argument(argument.to_owned()), then);
    }

    pub(crate) fn load(&mut self, ctx: &egui::Context, name: &str, source: Source, then: Then) {
        let request = Request {
            source,
            then,
            settings: self.settings.clone(),
            size: self.camera.map_or(UVec2::ZERO, |camera| camera.size),
            device: self.render.device.clone(),
            queue: self.render.queue.clone(),
        };
        let wake = ctx.clone();
        self.loader
            .start(name.to_owned(), request, move || wake.request_repaint());
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
        let Some((name, then, outcome)) = self.loader.take() else {
            return;
        };
        match outcome {
            Ok(Loaded { stage, renderer }) => {
                self.settings.show(&stage);
                then.apply(&mut self.settings, &stage);
                self.stage = stage;
                // The overlays go with the old renderer.
                self.renderer = renderer;
                // The panel still holds the old one's picture, which may have the same size.
                self.texture = self.texture.map(|(id, _)| (id, UVec2::ZERO));
                self.figures.forget();
                self.touch();
            }
            Err(error) => {
                if self.stage.is_nothing() && name != FIRST_SCENE {
                    self.open(ctx, FIRST_SCENE, Then::Show);
                }
                self.message = Some(format!("{name}: {error:#}"));
            }
        }
    }

    /// Takes files that were dropped on the window. What a scene names is read from its folder, dropped or not.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn take_files(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        let paths: Vec<_> = files.iter().map(|file| file.path().to_owned()).collect();
        if paths.is_empty() {
            return;
        }
        let (first, note) = scene_among(&paths);
        self.open(ctx, &paths[first].display().to_string(), Then::Show);
        self.message = note;
    }

    /// Takes files that were dropped on the page, once they have been read.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn take_files(&mut self, ctx: &egui::Context) {
        if let Some(dropped) = self.drops.take(ctx) {
            let source = Source::Read(dropped.stage);
            self.load(ctx, &dropped.name, source, Then::Show);
            self.message = dropped.note;
        }
    }
}
