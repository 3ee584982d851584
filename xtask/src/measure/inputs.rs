//! From what is typed to what the lab takes.

use crate::{cli::Backend, run::Usage};
use anyhow::Result;
use umbrage_core::Scene;
use umbrage_lab::compare::BackendChoice;
use umbrage_scenes::SceneError;
use umbrage_wgpu::AdapterChoice;

pub(super) fn choice(backend: Backend) -> BackendChoice {
    match backend {
        Backend::Available => BackendChoice::Available,
        Backend::Cpu => BackendChoice::Cpu,
        Backend::Wgpu => BackendChoice::Wgpu,
        Backend::Both => BackendChoice::Both,
    }
}

/// The adapter named, else what the environment asks for.
pub(super) fn adapter(name: Option<&String>) -> AdapterChoice {
    let from_env = AdapterChoice::from_env();
    AdapterChoice {
        name: name.cloned().or(from_env.name),
        ..from_env
    }
}

/// A scene by name or path.
pub(super) fn scene(name: &str) -> Result<Scene> {
    match umbrage_scenes::by_argument(name) {
        Ok(scene) => Ok(scene),
        Err(e @ SceneError::Unknown { .. }) => {
            Err(Usage(format!("{e} (see `cargo xtask compare --list`)")).into())
        }
        Err(e) => Err(e.into()),
    }
}
