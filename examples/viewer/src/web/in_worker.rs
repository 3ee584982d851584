//! The worker's half: plays a job, and tells the page what comes of it. [`worker`](super::worker) has the page's half.

use super::{
    making::{MadeStage, make, read_files},
    worker::{WorkerJob, object},
};
use crate::plan_job::{PlanRequest, planned, words};
use js_sys::{Array, Uint8Array};
use umbrage::plan::Cancel;
use wasm_bindgen::{JsCast as _, JsValue, closure::Closure};
use web_sys::DedicatedWorkerGlobalScope;

/// Gives the worker's script the function that plays jobs.
pub(super) fn offer() {
    std::panic::set_hook(Box::new(|panic| post("failed", &format!("{panic}").into())));
    let work = Closure::<dyn Fn(String, Array)>::new(|job: String, parts: Array| {
        match play(&job, &parts) {
            Ok(bytes) => post("done", &Uint8Array::from(bytes.as_slice()).buffer()),
            Err(error) => post("failed", &error.into()),
        }
    });
    let name = JsValue::from_str("umbrage_work");
    // Fails in no worker of ours: nothing there refuses new names.
    js_sys::Reflect::set(&js_sys::global(), &name, &work.into_js_value()).ok();
}

/// Sends the page one message.
fn post(kind: &str, value: &JsValue) {
    let message = object(&[(kind, value.clone())]);
    let scope = js_sys::global().unchecked_into::<DedicatedWorkerGlobalScope>();
    // Bytes are handed over instead of copied.
    let handed_over = match value.is_instance_of::<js_sys::ArrayBuffer>() {
        true => Array::of1(value),
        false => Array::new(),
    };
    // Plain texts and bytes can always be sent.
    scope
        .post_message_with_transfer(&message, &handed_over)
        .ok();
}

/// Plays a job. Returns what came out.
fn play(job: &str, parts: &Array) -> Result<Vec<u8>, String> {
    if job == WorkerJob::Plan.name() {
        return plan(&Uint8Array::new(&parts.get(0)).to_vec());
    }
    let goes_on = |at: String| {
        post("step", &at.into());
        true
    };
    if job == WorkerJob::Make.name() {
        return written(&make(parts, &goes_on)?);
    }
    if job == WorkerJob::Read.name() {
        return written(&read_files(parts, &goes_on)?);
    }
    match job {
        // For tests: faults that a job should never have.
        "panic" => panic!("a test asked for a panic"),
        "memory" => {
            let all: Vec<Vec<u8>> = (0..5).map(|_| Vec::with_capacity(1 << 30)).collect();
            Err(format!("{} GB are there", std::hint::black_box(all).len()))
        }
        _ => Err(format!(
            "a worker was asked for `{job}`, which it doesn't know"
        )),
    }
}

fn written(made: &MadeStage) -> Result<Vec<u8>, String> {
    post("step", &"is handed over".into());
    postcard::to_allocvec(made).map_err(|error| error.to_string())
}

fn plan(request: &[u8]) -> Result<Vec<u8>, String> {
    let request: PlanRequest = postcard::from_bytes(request).map_err(|error| error.to_string())?;
    // The page ends the whole worker instead.
    let cancel = Cancel::default();
    let tell = |step: umbrage::plan::Step<'_>| post("step", &words(step).into());
    let plan = planned(&request, &cancel, &tell).map_err(|error| error.to_string())?;
    // Techniques' settings are tables with names, which only formats with names can hold.
    serde_json::to_vec(&plan).map_err(|error| error.to_string())
}
