//! One report of a comparison's shards: byte for byte what one run would have written of the same figures.

use super::{assemble, files::Folder, store::Stored};
use crate::{LabError, compare::Comparison};
use std::{
    fs,
    path::{Path, PathBuf},
};
use umbrage_core::Invalid;

/// Joins the scenes of several folders. Returns the whole comparison and the page's path.
///
/// # Errors
/// When folders hold no scenes, scenes of different comparisons, one scene twice, or not all; or when a file cannot be
/// read or written.
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<(Comparison, PathBuf), LabError> {
    let mut found: Vec<(PathBuf, Stored)> = Vec::new();
    for folder in folders {
        let before = found.len();
        found.extend(scenes_in(folder)?);
        if found.len() == before {
            let what = format!("folder `{}`", folder.display());
            return Err(Invalid::new(what, "holds no scenes", "give folders that `compare --shard` wrote").into());
        }
    }
    found.sort_by_key(|(_, s)| s.place);
    check(&found)?;
    let folder = Folder::create(out)?;
    for (from, scene) in &found {
        let to = folder.unfinished(scene.name())?;
        for entry in list(from)? {
            let name = entry.file_name().unwrap_or_default().to_string_lossy().into_owned();
            to.write(&name, &fs::read(&entry).map_err(|source| LabError::Write { path: entry.clone(), source })?)?;
        }
        folder.finish(scene.name())?;
    }
    assemble::write(out, &folder, &found.into_iter().map(|(_, scene)| scene).collect::<Vec<_>>())
}

fn scenes_in(folder: &Path) -> Result<Vec<(PathBuf, Stored)>, LabError> {
    let finished = |p: &PathBuf| !p.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
    let inner = list(folder)?.into_iter().filter(finished);
    Ok(inner.filter_map(|path| Some((path.clone(), Stored::read(&path)?))).collect())
}

/// What lies in a folder, in a fixed order.
fn list(folder: &Path) -> Result<Vec<PathBuf>, LabError> {
    let broken = |source| LabError::Write { path: folder.to_owned(), source };
    let entries = fs::read_dir(folder).map_err(broken)?;
    let mut paths = entries.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>().map_err(broken)?;
    paths.sort();
    Ok(paths)
}

/// All of one comparison, each once.
fn check(found: &[(PathBuf, Stored)]) -> Result<(), Invalid> {
    let Some((first_path, first)) = found.first() else {
        return Err(Invalid::new("shards", "are missing", "give at least one folder"));
    };
    for (path, scene) in found {
        let what = format!("`{}`", path.display());
        let same_code = scene.environment.version == first.environment.version
            && scene.environment.commit == first.environment.commit
            && scene.environment.backends.len() == first.environment.backends.len();
        if scene.plan != first.plan || !same_code {
            let why = format!("was made for another comparison, or by other code, than `{}`", first_path.display());
            return Err(Invalid::new(what, why, "merge shards of one command line and one commit"));
        }
    }
    if let Some(pair) = found.windows(2).find(|p| p[0].1.place == p[1].1.place) {
        let why = format!("is the same scene as `{}`", pair[0].0.display());
        return Err(Invalid::new(format!("`{}`", pair[1].0.display()), why, "give each shard once"));
    }
    let missing: Vec<&str> = (0..first.plan.scenes.len())
        .filter(|place| found.iter().all(|(_, s)| s.place != *place))
        .map(|place| first.plan.scenes[place].as_str())
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    let why = format!("lack {} of {} scenes: {}", missing.len(), first.plan.scenes.len(), missing.join(", "));
    Err(Invalid::new("shards", why, "run the missing shards, then merge again"))
}
