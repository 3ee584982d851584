//! Workers of the page: what takes long is played beside the page, which goes on drawing.
//!
//! A worker is the same program once more, with memory of its own, in a thread of the browser. It plays one [`WorkerJob`] and ends. The page
//! sends `{ program, job, parts }`; the worker sends any number of `{ step: text }`, and at last `{ done: bytes }` or `{ failed: text }`.
//! Threads that share memory would need headers from the web server that many servers don't send.

use js_sys::{Array, Object, Reflect, Uint8Array};
use wasm_bindgen::{JsCast as _, JsValue, closure::Closure};
use web_sys::{ErrorEvent, MessageEvent, WorkerOptions, WorkerType};

/// Beside the page.
const SCRIPT: &str = "worker.js";

/// What a worker can be asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WorkerJob {
    /// Parts: the request. Done: the plan, as JSON.
    Plan,
    /// Parts: a built-in scene's name. Done: a [`MadeStage`](super::making::MadeStage).
    Make,
    /// Parts: each file's name, then the file; the scene comes first. Done: a [`MadeStage`](super::making::MadeStage).
    Read,
}

impl WorkerJob {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Make => "make",
            Self::Read => "read",
        }
    }
}

/// What a worker tells the page.
pub(crate) enum Told {
    /// What it is at, in words.
    Step(String),
    /// What came out.
    Done(Vec<u8>),
    Failed(String),
    /// Its script could not be loaded.
    NeverBegan(String),
}

/// A worker at its job; it ends when this is dropped, wherever it is.
pub(crate) struct PageWorker {
    worker: web_sys::Worker,
    _on_message: Closure<dyn Fn(MessageEvent)>,
    _on_error: Closure<dyn Fn(ErrorEvent)>,
}

impl PageWorker {
    /// Starts a worker. `on_told` is called with what it tells, between frames.
    ///
    /// # Errors
    /// Errors in words if the browser starts no worker. If it can't load the worker's script, that is told later.
    pub(crate) fn start(
        job: WorkerJob,
        parts: &Array,
        on_told: impl Fn(Told) + Clone + 'static,
    ) -> Result<Self, String> {
        let fault = |error: JsValue| {
            format!(
                "The browser starts no worker ({}). Load the page again, from a web server.",
                words(&error)
            )
        };
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = web_sys::Worker::new_with_options(SCRIPT, &options).map_err(fault)?;
        let of_message = on_told.clone();
        let on_message = Closure::<dyn Fn(MessageEvent)>::new(move |event: MessageEvent| {
            of_message(told(&event.data()));
        });
        worker.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
        let on_error = Closure::<dyn Fn(ErrorEvent)>::new(move |event: ErrorEvent| {
            // It is told here: the page's own listener need not stop the viewer.
            event.prevent_default();
            let message = Reflect::get(&event, &"message".into()).ok();
            on_told(match message.and_then(|message| message.as_string()) {
                Some(message) => Told::Failed(format!("{message}. Load the page again.")),
                // What could not be loaded comes without a message.
                None => Told::NeverBegan(format!("{SCRIPT} can't be loaded. Load the page again.")),
            });
        });
        worker.set_onerror(Some(on_error.as_ref().unchecked_ref()));
        let message = object(&[
            ("program", wasm_bindgen::module()),
            ("job", job.name().into()),
            ("parts", parts.into()),
        ]);
        worker.post_message(&message).map_err(fault)?;
        Ok(Self {
            worker,
            _on_message: on_message,
            _on_error: on_error,
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

/// Returns an object of JavaScript.
pub(super) fn object(fields: &[(&str, JsValue)]) -> Object {
    let out = Object::new();
    for (name, value) in fields {
        // A fresh object takes any field.
        Reflect::set(&out, &JsValue::from_str(name), value).ok();
    }
    out
}

/// Returns what a message means.
fn told(message: &JsValue) -> Told {
    let get = |name: &str| {
        let value = Reflect::get(message, &JsValue::from_str(name)).ok();
        value.filter(|value| !value.is_undefined())
    };
    if let Some(step) = get("step").and_then(|step| step.as_string()) {
        return Told::Step(step);
    }
    if let Some(bytes) = get("done") {
        return Told::Done(Uint8Array::new(&bytes).to_vec());
    }
    let failed = get("failed").and_then(|failed| failed.as_string());
    Told::Failed(failed.unwrap_or_else(|| "it told nothing that makes sense".to_owned()))
}

/// Returns an error of JavaScript in words, without the places in scripts that it names.
pub(super) fn words(error: &JsValue) -> String {
    match error.dyn_ref::<js_sys::Error>() {
        Some(error) => error.message().into(),
        None => error.as_string().unwrap_or_else(|| format!("{error:?}")),
    }
}
