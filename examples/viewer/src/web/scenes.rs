//! Scenes that a worker makes or reads, and the page uploads.

use super::worker::{self, WorkerTask, error_label};
use crate::{
    job::Job,
    loading::SceneSource,
    stage::{OnStep, ViewerScene},
};
use anyhow::{Context as _, Result, anyhow};
use js_sys::{Array, Uint8Array};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use umbrage::scenes::FilesInMemory;
use wasm_bindgen::JsCast as _;
use web_sys::{File, FileReaderSync};

/// Outcome of a worker.
#[derive(Serialize, Deserialize)]
pub(crate) struct MadeStage {
    pub stage: ViewerScene,
    /// Missing files that a model names.
    missing: Vec<PathBuf>,
}

impl MadeStage {
    /// Returns a note about missing files of the scene.
    pub(crate) fn note(&self, name: &str) -> Option<String> {
        let missing = self.missing.iter().map(|path| path.display().to_string());
        let files = missing.collect::<Vec<_>>().join(", ");
        (!files.is_empty())
            .then(|| format!("{name} is shown without {files}: drop all of them together."))
    }
}

/// Starts a worker that makes or reads a scene. Without workers, the page makes built-in scenes
/// itself.
pub(crate) fn start(ctx: &egui::Context, source: &SceneSource) -> Job<MadeStage> {
    let read = |bytes: &[u8]| {
        postcard::from_bytes(bytes)
            .map_err(|error| anyhow!("the worker's scene can't be read: {error}"))
    };
    let parts = Array::new();
    let files = match source {
        SceneSource::Argument(name) => {
            parts.push(&name.as_str().into());
            let name = name.clone();
            let without_worker = move |error: anyhow::Error| {
                log::warn!("{name} is made without a worker: {error}");
                make(&name, &|_| true)
            };
            return worker::start(ctx, WorkerTask::Make, &parts, read, without_worker);
        }
        SceneSource::Files(files) => files,
    };
    for file in files {
        let Some(web_file) = file.web_file() else {
            continue;
        };
        parts.push(&file.path().display().to_string().into());
        parts.push(web_file);
    }
    worker::start(ctx, WorkerTask::Read, &parts, read, Err)
}

/// Makes a built-in scene.
///
/// # Errors
/// Returns an error if there is none of that name.
pub(super) fn make(name: &str, on_step: OnStep<'_>) -> Result<MadeStage> {
    let stage = ViewerScene::of_argument(name, on_step)?;
    Ok(MadeStage {
        stage: stage.context("it was cancelled")?,
        missing: Vec::new(),
    })
}

/// Reads a scene from files. Only available in workers.
///
/// # Errors
/// Returns an error if they can't be read.
pub(super) fn read_files(parts: &Array, on_step: OnStep<'_>) -> Result<MadeStage> {
    on_step("reading".to_owned());
    let reader = FileReaderSync::new().map_err(|error| anyhow!(error_label(&error)))?;
    let mut files = FilesInMemory::default();
    for i in (0..parts.length()).step_by(2) {
        let name = parts.get(i).as_string().unwrap_or_default();
        let file: File = parts.get(i + 1).unchecked_into();
        let buffer = reader.read_as_array_buffer(&file).map_err(|error| {
            anyhow!("{name}: the browser can't read it: {}", error_label(&error))
        })?;
        files.insert(&name, Uint8Array::new(&buffer).to_vec());
    }
    let scene = parts.get(0).as_string().context("there is no file")?;
    Ok(MadeStage {
        stage: ViewerScene::read(&scene, &files)?,
        missing: files.missing_files(),
    })
}
