//! In the worker: makes the scenes that [`WorkerJob::Make`](super::worker::WorkerJob) and [`WorkerJob::Read`](super::worker::WorkerJob)
//! ask for.

use super::worker::words;
use crate::{loading::GoesOn, stage::Stage};
use js_sys::Array;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use umbrage::scenes::FilesInMemory;
use wasm_bindgen::JsCast as _;
use web_sys::{File, FileReaderSync};

/// What a worker made.
#[derive(Serialize, Deserialize)]
pub(super) struct MadeStage {
    pub stage: Stage,
    /// What a model names that was not dropped.
    pub missing: Vec<PathBuf>,
}

/// Makes a built-in scene.
///
/// # Errors
/// Errors in words if there is none of that name.
pub(super) fn make(parts: &Array, goes_on: GoesOn<'_>) -> Result<MadeStage, String> {
    let name = parts.get(0).as_string().unwrap_or_default();
    let stage = Stage::of_argument(&name, goes_on).map_err(|error| format!("{error:#}"))?;
    Ok(MadeStage {
        stage: stage.ok_or("it was given up")?,
        missing: Vec::new(),
    })
}

/// Reads a scene from files.
///
/// # Errors
/// Errors in words if they can't be read.
pub(super) fn read_files(parts: &Array, goes_on: GoesOn<'_>) -> Result<MadeStage, String> {
    goes_on("is read".to_owned());
    let reader = FileReaderSync::new().map_err(|error| words(&error))?;
    let mut files = FilesInMemory::default();
    let mut scene = None;
    for i in (0..parts.length()).step_by(2) {
        let name = parts.get(i).as_string().unwrap_or_default();
        let file: File = parts.get(i + 1).unchecked_into();
        let buffer = reader
            .read_as_array_buffer(&file)
            .map_err(|error| format!("{name}: the browser can't read it: {}", words(&error)))?;
        files.insert(&name, js_sys::Uint8Array::new(&buffer).to_vec());
        scene.get_or_insert(name);
    }
    let name = scene.ok_or("there is no file")?;
    let stage = Stage::read(&name, &files).map_err(|error| format!("{error:#}"))?;
    Ok(MadeStage {
        stage,
        missing: files.missing(),
    })
}
