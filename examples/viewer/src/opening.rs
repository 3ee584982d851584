//! Opens scenes: built-in ones, files, and files dropped on the window.

use crate::{
    drops::scene_among,
    loading::{Loading, Request, SceneSource, Then, absolute},
    viewer::{FIRST_SCENE, Viewer},
};
use umbrage::glam::UVec2;

impl Viewer {
    /// Starts to load another scene, and cancels one that is loading. The current scene stays until
    /// the new one is ready. If the new one can't be shown, a message states the reason.
    pub(crate) fn open(&mut self, ctx: &egui::Context, argument: &str, then: Then) {
        self.load(
            ctx,
            argument,
            SceneSource::Argument(absolute(argument)),
            then,
        );
    }

    fn load(&mut self, ctx: &egui::Context, name: &str, source: SceneSource, then: Then) {
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
        // Cancel the old one before the new one starts.
        self.loading = None;
        self.loading = Some(Loading::start(ctx, request));
    }

    /// Cancels loading and keeps the current scene.
    pub(crate) fn cancel_loading(&mut self) {
        self.loading = None;
        if self.stage.is_nothing() {
            self.message = Some("Press F2 to open a scene or a file.".to_owned());
        }
    }

    /// Shows a scene that was loaded since the last frame.
    pub(crate) fn take_loaded(&mut self, ctx: &egui::Context) {
        let Some(outcome) = self.loading.as_mut().and_then(Loading::take) else {
            return;
        };
        let Some(Loading { request, .. }) = self.loading.take() else {
            return;
        };
        let loaded = match outcome {
            Ok(loaded) => loaded,
            Err(error) => {
                self.first_shown = None;
                let name = request.name;
                if self.stage.is_nothing() && name != FIRST_SCENE {
                    self.open(ctx, FIRST_SCENE, Then::Show);
                }
                let error = format!("{error:#}");
                // Errors of files start with the file.
                let has_name = error.contains(&name);
                self.message = Some(if has_name {
                    error
                } else {
                    format!("{name}: {error}")
                });
                return;
            }
        };
        self.settings.show(&loaded.stage);
        request.then.apply(&mut self.settings, &loaded.stage);
        if let Some(first) = self.first_shown.take() {
            first.apply(&mut self.settings);
        }
        self.stage = loaded.stage;
        self.renderer = loaded.renderer;
        self.path = loaded.path;
        self.figures.forget(&mut self.renderer);
        // Discard the plan of the old scene.
        self.planning = None;
        self.plan = None;
        self.message = loaded.note.or_else(|| self.message.take());
        self.pace.touch();
    }

    /// Opens files dropped on the window or the page. On the desktop, files that a scene names are
    /// read from its folder, dropped or not.
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
            self.load(ctx, &name, SceneSource::Files(files), Then::Show);
        }
        self.message = note;
    }
}
