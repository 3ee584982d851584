//! Files that were dropped on the page, read in a worker: large models take seconds.

use super::worker::{PageWorker, Told, WorkerJob, words};
use crate::{
    drops::{Dropped, scene_among},
    stage::Stage,
};
use anyhow::anyhow;
use js_sys::Array;
use serde::{Deserialize, Serialize};
use std::{cell::RefCell, path::PathBuf, rc::Rc};
use umbrage::scenes::FilesInMemory;
use wasm_bindgen::JsCast as _;
use web_sys::{File, FileReaderSync};

/// What a worker made of files.
#[derive(Serialize, Deserialize)]
pub(super) struct FileRead {
    stage: Stage,
    /// What the model names that was not dropped.
    missing: Vec<PathBuf>,
}

/// Files that are being read.
#[derive(Default)]
pub(crate) struct Drops {
    reading: Option<Reading>,
    told: Rc<RefCell<Option<Told>>>,
}

struct Reading {
    name: String,
    /// What else the user should know of what was dropped.
    note: Option<String>,
    _worker: PageWorker,
}

impl Drops {
    /// Begins to read what was dropped since the last frame, and returns what was read since then.
    pub(crate) fn take(&mut self, ctx: &egui::Context) -> Option<Dropped> {
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        if !dropped.is_empty()
            && let Err((name, error)) = self.begin(&dropped, ctx)
        {
            return Some(Dropped {
                name,
                stage: Err(anyhow!(error)),
                note: None,
            });
        }
        let told = match self.told.take()? {
            Told::Step(_) => return None,
            told => told,
        };
        let Reading { name, note, .. } = self.reading.take()?;
        Some(finished(name, note, told))
    }

    /// Calls off what is being read.
    pub(crate) fn cancel(&mut self) {
        *self = Self::default();
    }

    /// The name of the file that is being read.
    pub(crate) fn reading(&self) -> Option<&str> {
        self.reading.as_ref().map(|reading| reading.name.as_str())
    }

    /// Gives the files to a worker. What was being read is given up.
    ///
    /// # Errors
    /// Errors with the scene's name, if there is no worker.
    fn begin(
        &mut self,
        dropped: &[egui::DroppedFileHandle],
        ctx: &egui::Context,
    ) -> Result<(), (String, String)> {
        self.cancel();
        let paths: Vec<PathBuf> = dropped.iter().map(|file| file.path().to_owned()).collect();
        let (first, note) = scene_among(&paths);
        let name = paths[first].display().to_string();
        let parts = Array::new();
        let others = (0..dropped.len()).filter(|&i| i != first);
        for i in std::iter::once(first).chain(others) {
            let Some(file) = dropped[i].web_file() else {
                return Err((name, "the browser gave no file".to_owned()));
            };
            parts.push(&paths[i].display().to_string().into());
            parts.push(file);
        }
        let (told, wake) = (self.told.clone(), ctx.clone());
        let on_told = move |news| {
            told.borrow_mut().get_or_insert(news);
            wake.request_repaint();
        };
        match PageWorker::start(WorkerJob::Read, &parts, on_told) {
            Ok(worker) => {
                self.reading = Some(Reading {
                    name,
                    note,
                    _worker: worker,
                });
                Ok(())
            }
            Err(error) => Err((name, error)),
        }
    }
}

fn finished(name: String, mut note: Option<String>, told: Told) -> Dropped {
    let stage = match told {
        Told::Done(bytes) => match postcard::from_bytes::<FileRead>(&bytes) {
            Ok(read) => {
                if !read.missing.is_empty() {
                    let missing: Vec<String> = read
                        .missing
                        .iter()
                        .map(|path| path.display().to_string())
                        .collect();
                    note = Some(format!(
                        "{name} is shown without {}: drop all of them together.",
                        missing.join(", ")
                    ));
                }
                Ok(read.stage)
            }
            Err(error) => Err(anyhow!("what the worker read can't be taken over: {error}")),
        },
        Told::Failed(error) => Err(anyhow!(error)),
        Told::Step(step) => Err(anyhow!("the worker ended at `{step}`")),
    };
    Dropped { name, stage, note }
}

/// In the worker: reads a scene from files, as [`WorkerJob::Read`] has them.
pub(super) fn read_files(parts: &Array) -> Result<FileRead, String> {
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
    Ok(FileRead {
        stage,
        missing: files.missing(),
    })
}
