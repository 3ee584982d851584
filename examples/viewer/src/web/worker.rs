//! Workers of the page, which execute long tasks while the page continues to draw.
//!
//! A worker is a second instance of the program, with separate memory, in a thread of the browser.
//! It executes one [`WorkerTask`] and ends. The page sends `{ program, job, parts }`. The worker
//! sends any number of `{ step: text }`, and finally `{ done: bytes }` or `{ failed: text }`.
//! Threads with shared memory would need headers that many web servers don't send.

use crate::job::Job;
use anyhow::{Result, anyhow};
use js_sys::{Array, Object, Reflect, Uint8Array};
use std::{cell::Cell, rc::Rc};
use wasm_bindgen::{JsCast as _, JsValue, closure::Closure};
use web_sys::{ErrorEvent, MessageEvent, WorkerOptions, WorkerType};

/// Path of the worker's script, relative to the page.
const SCRIPT: &str = "worker.js";

/// Tasks of workers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WorkerTask {
    /// Parts: the request. Done: the plan, as JSON.
    Plan,
    /// Parts: a built-in scene's name. Done: a [`MadeStage`](super::scenes::MadeStage).
    Make,
    /// Parts: each file's name, then the file; the scene comes first. Done: a
    /// [`MadeStage`](super::scenes::MadeStage).
    Read,
}

impl WorkerTask {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Make => "make",
            Self::Read => "read",
        }
    }
}

/// Starts a worker. `read` parses its outcome. `without_worker` returns the outcome if the worker
/// could not start, for the given reason.
pub(crate) fn start<T: 'static>(
    ctx: &egui::Context,
    task: WorkerTask,
    parts: &Array,
    read: impl Fn(&[u8]) -> Result<T> + 'static,
    without_worker: impl Fn(anyhow::Error) -> Result<T> + 'static,
) -> Job<T> {
    let (mut job, progress) = Job::new(ctx);
    let has_ended = Cell::new(false);
    let on_message = Rc::new(move |message| match message {
        Message::Step(step) => {
            progress.step(step);
        }
        // Ignore repetitions: the program reports a panic first, and the worker's script reports it
        // again.
        _ if has_ended.replace(true) => {}
        Message::Done(bytes) => progress.publish(read(&bytes)),
        Message::Failed(error) => progress.publish(Err(anyhow!(error))),
        Message::NeverBegan(error) => progress.publish(without_worker(anyhow!(error))),
    });
    match PageWorker::start(task, parts, on_message.clone()) {
        Ok(worker) => job.worker = Some(worker),
        Err(error) => on_message(Message::NeverBegan(format!(
            "The browser can't start a worker ({}). Load the page again, from a web server.",
            error_label(&error)
        ))),
    }
    job
}

/// Message of a worker to the page.
enum Message {
    /// Description of the current step.
    Step(String),
    Done(Vec<u8>),
    Failed(String),
    /// The worker's script could not be loaded.
    NeverBegan(String),
}

impl Message {
    fn of_event(event: &MessageEvent) -> Self {
        let get = |name: &str| {
            let value = Reflect::get(&event.data(), &name.into()).ok();
            value.filter(|value| !value.is_undefined())
        };
        if let Some(step) = get("step").and_then(|step| step.as_string()) {
            return Self::Step(step);
        }
        if let Some(bytes) = get("done") {
            return Self::Done(Uint8Array::new(&bytes).to_vec());
        }
        let failed = get("failed").and_then(|failed| failed.as_string());
        Self::Failed(failed.unwrap_or_else(|| "the worker's message can't be read".to_owned()))
    }

    fn of_error(event: &ErrorEvent) -> Self {
        // Report it here, and keep the page's own listener from stopping the viewer.
        event.prevent_default();
        let message = Reflect::get(event, &"message".into()).ok();
        match message.and_then(|message| message.as_string()) {
            Some(message) => Self::Failed(format!("{message}. Load the page again.")),
            // A script that could not be loaded causes an error without a message.
            None => Self::NeverBegan(format!("{SCRIPT} can't be loaded. Load the page again.")),
        }
    }
}

/// A running worker, which is terminated on drop.
pub(crate) struct PageWorker {
    worker: web_sys::Worker,
    _on_message: Closure<dyn Fn(MessageEvent)>,
    _on_error: Closure<dyn Fn(ErrorEvent)>,
}

impl PageWorker {
    /// Starts a worker. `on_message` is called between frames.
    ///
    /// # Errors
    /// Returns an error if the browser can't start a worker. If it can't load the worker's script,
    /// a later message reports that.
    fn start(
        task: WorkerTask,
        parts: &Array,
        on_message: Rc<impl Fn(Message) + 'static>,
    ) -> Result<Self, JsValue> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = web_sys::Worker::new_with_options(SCRIPT, &options)?;
        let take = on_message.clone();
        let of_message = Closure::<dyn Fn(MessageEvent)>::new(move |event: MessageEvent| {
            take(Message::of_event(&event));
        });
        worker.set_onmessage(Some(of_message.as_ref().unchecked_ref()));
        let of_error = Closure::<dyn Fn(ErrorEvent)>::new(move |event: ErrorEvent| {
            on_message(Message::of_error(&event));
        });
        worker.set_onerror(Some(of_error.as_ref().unchecked_ref()));
        worker.post_message(&object(&[
            ("program", wasm_bindgen::module()),
            ("job", task.name().into()),
            ("parts", parts.into()),
        ]))?;
        Ok(Self {
            worker,
            _on_message: of_message,
            _on_error: of_error,
        })
    }
}

impl Drop for PageWorker {
    fn drop(&mut self) {
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
        self.worker.terminate();
    }
}

/// Returns a JavaScript object.
pub(super) fn object(fields: &[(&str, JsValue)]) -> Object {
    let out = Object::new();
    for (name, value) in fields {
        // This can't fail: a new object accepts any field.
        Reflect::set(&out, &JsValue::from_str(name), value).ok();
    }
    out
}

/// Returns the text of a JavaScript error, without positions in scripts.
pub(super) fn error_label(error: &JsValue) -> String {
    match error.dyn_ref::<js_sys::Error>() {
        Some(error) => error.message().into(),
        None => error.as_string().unwrap_or_else(|| format!("{error:?}")),
    }
}
