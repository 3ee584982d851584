//! From what is typed to what the lab takes.

use crate::program::Program;
use crate::{args::Backend, usage::Usage};
use anyhow::Result;
use umbrage_core::Scene;
use umbrage_lab::compare::BackendChoice;
use umbrage_scenes::SceneError;
use umbrage_wgpu::AdapterChoice;

pub(crate) fn choice(backend: Backend) -> BackendChoice {
    match backend {
        Backend::Available => BackendChoice::Available,
        Backend::Cpu => BackendChoice::Cpu,
        Backend::Wgpu => BackendChoice::Wgpu,
        Backend::Both => BackendChoice::Both,
    }
}

/// The adapter named, else what the environment asks for.
pub(crate) fn adapter(name: Option<&String>) -> AdapterChoice {
    let from_env = AdapterChoice::from_env();
    AdapterChoice {
        name: name.cloned().or(from_env.name),
        ..from_env
    }
}

/// A scene by name or path.
pub(crate) fn scene(program: &Program, name: &str) -> Result<Scene> {
    match umbrage_scenes::by_argument(name) {
        Ok(scene) => Ok(scene),
        Err(e @ SceneError::Unknown { .. }) => {
            let list = format!("{} compare --list", program.invocation);
            Err(Usage(format!("{e} (see `{list}`)")).into())
        }
        Err(e) => Err(e.into()),
    }
}
