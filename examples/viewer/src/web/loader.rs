//! In browsers a worker makes scenes and reads files, which can take seconds; the page takes over what was made.

use super::{
    making::MadeStage,
    worker::{PageWorker, Told, WorkerJob},
};
use crate::{
    loading::{Outcome, Request, Source, Then, going_to_device},
    stage::Stage,
};
use anyhow::{Result, anyhow};
use js_sys::Array;
use std::{cell::RefCell, rc::Rc};
use web_time::Instant;

/// What a scene's worker told last.
#[derive(Default)]
struct News {
    /// What is being done, in words.
    at: String,
    end: Option<Told>,
}

/// A scene that is being made or read.
struct SceneJob {
    request: Request,
    begun: Instant,
    news: Rc<RefCell<News>>,
    wake: Rc<dyn Fn()>,
    /// None once it has told its end, and where there is none.
    worker: Option<PageWorker>,
    /// What the worker made, until the next frame takes it to the device.
    made: Option<Result<MadeStage>>,
}

/// Loads one scene at a time; a newer one replaces it.
#[derive(Default)]
pub(crate) struct Loader {
    job: Option<SceneJob>,
}

impl Loader {
    /// Begins; what was being loaded is given up. `wake` is called when there is something new to show.
    pub(crate) fn start(&mut self, request: Request, wake: impl Fn() + 'static) {
        self.cancel();
        let news = Rc::new(RefCell::new(News {
            at: "begins".to_owned(),
            end: None,
        }));
        let wake: Rc<dyn Fn()> = Rc::new(wake);
        let (told, woken) = (news.clone(), wake.clone());
        let on_told = move |event| {
            match event {
                Told::Step(step) => told.borrow_mut().at = step,
                // A panic is told first by the program, and again by the worker's script.
                end => {
                    told.borrow_mut().end.get_or_insert(end);
                }
            }
            woken();
        };
        let worker = parts(&request.source)
            .and_then(|(job, parts)| PageWorker::start(job, &parts, on_told))
            .map_err(|error| news.borrow_mut().end = Some(Told::NeverBegan(error)));
        self.job = Some(SceneJob {
            request,
            begun: Instant::now(),
            news,
            wake,
            worker: worker.ok(),
            made: None,
        });
    }

    /// Gives up what is being loaded: the worker ends at once.
    pub(crate) fn cancel(&mut self) {
        self.job = None;
    }

    /// The scene that is being made.
    pub(crate) fn argument(&self) -> Option<String> {
        match &self.job.as_ref()?.request.source {
            Source::Argument(argument) => Some(argument.clone()),
            Source::Files(_) => None,
        }
    }

    /// What follows once it is there.
    pub(crate) fn then(&self) -> Option<&Then> {
        self.job.as_ref().map(|job| &job.request.then)
    }

    /// The name of what is being loaded.
    pub(crate) fn name(&self) -> Option<&str> {
        self.job.as_ref().map(|job| job.request.name.as_str())
    }

    /// What is being loaded, and what is done with it, in words; none while nothing is.
    pub(crate) fn at(&self) -> Option<String> {
        let job = self.job.as_ref()?;
        let seconds = job.begun.elapsed().as_secs();
        let at = &job.news.borrow().at;
        Some(format!("{}: {at} ({seconds} s)", job.request.name))
    }

    /// Returns what has been loaded since it was asked last. What a worker made goes to the device with the next call, so that a frame
    /// says so before: the page stands still meanwhile.
    pub(crate) fn take(&mut self) -> Option<Outcome> {
        let job = self.job.as_mut()?;
        if job.made.is_some() {
            return self.job.take()?.outcome();
        }
        let end = job.news.borrow_mut().end.take()?;
        job.worker = None;
        let made = job.made(end);
        if let Ok(made) = &made {
            job.news.borrow_mut().at = going_to_device(&made.stage);
        }
        job.made = Some(made);
        (job.wake)();
        None
    }
}

impl SceneJob {
    /// Returns what a worker made. Where there is no worker, the page makes built-in scenes itself.
    fn made(&self, end: Told) -> Result<MadeStage> {
        match (end, &self.request.source) {
            (Told::Done(bytes), _) => postcard::from_bytes(&bytes)
                .map_err(|error| anyhow!("what the worker made can't be taken over: {error}")),
            (Told::NeverBegan(error), Source::Argument(argument)) => {
                log::warn!("{argument} is made without a worker: {error}");
                let stage = Stage::of_argument(argument, &|_| true)?;
                Ok(MadeStage {
                    stage: stage.ok_or_else(|| anyhow!(error))?,
                    missing: Vec::new(),
                })
            }
            (Told::NeverBegan(error) | Told::Failed(error), _) => Err(anyhow!(error)),
            (Told::Step(step), _) => Err(anyhow!("the worker ended at `{step}`")),
        }
    }

    /// Takes what was made to the device.
    fn outcome(self) -> Option<Outcome> {
        let (name, then) = (self.request.name.clone(), self.request.then.clone());
        let loaded = self.made?.and_then(|MadeStage { stage, missing }| {
            let note = note(&name, &missing);
            let loaded = self.request.prepared(stage, &|_| true)?;
            loaded
                .map(|loaded| loaded.with_note(note))
                .ok_or_else(|| anyhow!("it was given up"))
        });
        Some(Outcome { name, then, loaded })
    }
}

/// Says without which files a model is shown.
fn note(name: &str, missing: &[std::path::PathBuf]) -> Option<String> {
    let missing: Vec<String> = missing
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let files = missing.join(", ");
    (!missing.is_empty())
        .then(|| format!("{name} is shown without {files}: drop all of them together."))
}

/// Returns the job that loads from a source, with its parts.
fn parts(source: &Source) -> Result<(WorkerJob, Array), String> {
    let files = match source {
        Source::Argument(name) => {
            return Ok((WorkerJob::Make, Array::of1(&name.as_str().into())));
        }
        Source::Files(files) => files,
    };
    let parts = Array::new();
    for file in files {
        parts.push(&file.path().display().to_string().into());
        parts.push(file.web_file().ok_or("the browser gave no file")?);
    }
    Ok((WorkerJob::Read, parts))
}
