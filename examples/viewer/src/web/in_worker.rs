//! The program in a worker: executes a task, and reports to the page. [`worker`](super::worker) is
//! the page's half.

use super::{
    scenes::{MadeStage, make, read_files},
    worker::{WorkerTask, object},
};
use crate::plan;
use anyhow::{Result, bail};
use js_sys::{Array, Uint8Array};
use umbrage::plan::{Cancel, Step};
use wasm_bindgen::{JsCast as _, JsValue, closure::Closure};
use web_sys::DedicatedWorkerGlobalScope;

/// Adds the function that executes tasks to the worker's script.
pub(super) fn offer() {
    std::panic::set_hook(Box::new(|panic| post("failed", &format!("{panic}").into())));
    let work = Closure::<dyn Fn(String, Array)>::new(|task: String, parts: Array| {
        match run(&task, &parts) {
            Ok(bytes) => post("done", &Uint8Array::from(bytes.as_slice()).buffer()),
            Err(error) => post("failed", &format!("{error:#}").into()),
        }
    });
    let name = JsValue::from_str("umbrage_work");
    // This can't fail: our worker refuses no names.
    js_sys::Reflect::set(&js_sys::global(), &name, &work.into_js_value()).ok();
}

/// Sends the page one message.
fn post(kind: &str, value: &JsValue) {
    let message = object(&[(kind, value.clone())]);
    let scope = js_sys::global().unchecked_into::<DedicatedWorkerGlobalScope>();
    // Transfer bytes instead of copying them.
    let handed_over = match value.is_instance_of::<js_sys::ArrayBuffer>() {
        true => Array::of1(value),
        false => Array::new(),
    };
    // This can't fail for texts and bytes.
    scope
        .post_message_with_transfer(&message, &handed_over)
        .ok();
}

/// Executes a task. Returns the outcome as bytes.
fn run(task: &str, parts: &Array) -> Result<Vec<u8>> {
    let first = parts.get(0);
    let on_step = |step: String| {
        post("step", &step.into());
        true
    };
    if task == WorkerTask::Plan.name() {
        return plan(&Uint8Array::new(&first).to_vec());
    }
    if task == WorkerTask::Make.name() {
        return write(&make(&first.as_string().unwrap_or_default(), &on_step)?);
    }
    if task == WorkerTask::Read.name() {
        return write(&read_files(parts, &on_step)?);
    }
    match task {
        // Simulate failures of a task, for tests.
        "panic" => panic!("a test requested a panic"),
        "memory" => {
            let all: Vec<Vec<u8>> = (0..5).map(|_| Vec::with_capacity(1 << 30)).collect();
            bail!("{} GB are there", std::hint::black_box(all).len())
        }
        _ => bail!("a worker has no task `{task}`"),
    }
}

fn write(made: &MadeStage) -> Result<Vec<u8>> {
    post("step", &"is handed over".into());
    Ok(postcard::to_allocvec(made)?)
}

fn plan(request: &[u8]) -> Result<Vec<u8>> {
    let (request, refused): (plan::PlanRequest, Vec<String>) = postcard::from_bytes(request)?;
    let on_step = |step: Step<'_>| post("step", &plan::step_label(step).into());
    // The page terminates the whole worker instead of cancelling.
    let plan = plan::plan(&request, &refused, &Cancel::default(), &on_step)?;
    // Settings of techniques are tables with names, which require a self-describing format.
    Ok(serde_json::to_vec(&plan)?)
}
