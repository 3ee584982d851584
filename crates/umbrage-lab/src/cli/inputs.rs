//! Converts arguments of the command line to inputs of the lab.

use crate::cli::program::Program;
use crate::cli::{args::shared::BackendName, usage::Usage};
use crate::compare::Backends;
use anyhow::Result;
use std::path::Path;
use umbrage_core::{BackendError, Scene};
use umbrage_plan::cost::PriceList;
use umbrage_scenes::{SceneError, SizedFilesOnDisk};
use umbrage_wgpu::{AdapterChoice, Gpu};

/// Opens the backends, wgpu on the named adapter.
pub(crate) fn open(backend: BackendName, adapter: Option<&String>) -> Result<Backends> {
    let choice = self::adapter(adapter);
    let opened = match backend {
        BackendName::Available => Backends::available(&choice),
        BackendName::Cpu => Ok(Backends::cpu()),
        BackendName::Wgpu => Backends::wgpu(&choice),
        BackendName::Both => Backends::both(&choice),
    };
    opened.map_err(|e| of_adapter(e, adapter))
}

/// Opens the named adapter.
pub(crate) fn gpu(adapter: Option<&String>) -> Result<Gpu> {
    Gpu::new(&self::adapter(adapter)).map_err(|e| of_adapter(e, adapter))
}

fn of_adapter(error: BackendError, name: Option<&String>) -> anyhow::Error {
    match error {
        // The name is wrong, not the machine.
        e @ BackendError::NoAdapter { .. } if name.is_some() => {
            Usage(format!("--adapter: {e}")).into()
        }
        e => e.into(),
    }
}

/// Returns the choice of the named adapter. Without a name the environment decides.
pub(crate) fn adapter(name: Option<&String>) -> AdapterChoice {
    let from_env = AdapterChoice::from_env();
    AdapterChoice {
        name: name.cloned().or(from_env.name),
        ..from_env
    }
}

/// Reads the prices in a file. Returns the built-in ones without a file.
pub(crate) fn prices(path: Option<&Path>) -> Result<PriceList> {
    let Some(path) = path else {
        return Ok(PriceList::default());
    };
    let unusable = |why: String| Usage(format!("--prices `{}`: {why}", path.display()));
    if path
        .extension()
        .is_some_and(|extension| extension == "json")
    {
        return Ok(crate::card::read_prices(path).map_err(|e| unusable(e.to_string()))?);
    }
    let text = std::fs::read_to_string(path).map_err(|e| unusable(e.to_string()))?;
    let list = PriceList::from_toml(&text).map_err(|e| unusable(e.to_string()))?;
    Ok(list)
}

/// Returns a scene by name or path. Prints the notices of its reader.
pub(crate) fn scene(program: &Program, name: &str) -> Result<Scene> {
    let scene = load(program, name, u32::MAX)?;
    for notice in &scene.notices {
        eprintln!("note: {notice}");
    }
    Ok(scene)
}

/// Returns a scene by name or path. Images of files are reduced to `color_side`
/// ([`Files::color_side`](umbrage_scenes::Files::color_side)).
pub(crate) fn load(program: &Program, name: &str, color_side: u32) -> Result<Scene> {
    let is_file = umbrage_scenes::find(name).is_none() && umbrage_scenes::file_of(name).is_some();
    let scene = if is_file {
        umbrage_scenes::read(name, &SizedFilesOnDisk { color_side })
    } else {
        umbrage_scenes::by_argument(name)
    };
    match scene {
        Ok(scene) => Ok(scene),
        Err(e @ SceneError::Unknown { .. }) => {
            let list = format!("{} compare --list", program.invocation);
            Err(Usage(format!("{e} (see `{list}`)")).into())
        }
        Err(e) => Err(e.into()),
    }
}
