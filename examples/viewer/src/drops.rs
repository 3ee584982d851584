//! Files that are dropped on the window.

use crate::stage::Stage;
use anyhow::Result;

/// A dropped file's name, and the scene in it.
pub(crate) type Dropped = (String, Result<Stage>);

#[cfg(not(target_arch = "wasm32"))]
#[derive(Default)]
pub(crate) struct Drops;

#[cfg(not(target_arch = "wasm32"))]
impl Drops {
    /// Returns what was dropped since the last frame.
    pub(crate) fn take(&mut self, ctx: &egui::Context) -> Vec<Dropped> {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        let open = |file: egui::DroppedFileHandle| {
            let path = file.path().display().to_string();
            let stage = Stage::load(&path);
            (path, stage)
        };
        files.into_iter().map(open).collect()
    }
}

/// Browsers read files behind a frame's back: what was read lies here until the next frame.
#[cfg(target_arch = "wasm32")]
#[derive(Default)]
pub(crate) struct Drops(std::rc::Rc<std::cell::RefCell<Vec<Dropped>>>);

#[cfg(target_arch = "wasm32")]
impl Drops {
    /// Begins to read what was dropped, and returns what was read since the last frame.
    pub(crate) fn take(&mut self, ctx: &egui::Context) -> Vec<Dropped> {
        for file in ctx.input(|input| input.raw.dropped_files.clone()) {
            let read = self.0.clone();
            let wake = ctx.clone();
            wasm_bindgen_futures::spawn_local(async move {
                let name = file.path().display().to_string();
                let bytes = file.bytes_async().await;
                let stage = bytes
                    .map_err(anyhow::Error::msg)
                    .and_then(|bytes| Stage::read(&name, &bytes));
                read.borrow_mut().push((name, stage));
                wake.request_repaint();
            });
        }
        self.0.take()
    }
}
