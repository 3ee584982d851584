//! The scenes of a folder's last run. The folder may also contain scenes of other runs, which are
//! ignored.

use super::store::{self, ComparisonPlan, Stored};
use crate::{
    compare::{Environment, SceneResult},
    error::LabError,
    output::folder::Folder,
};
use serde::{Deserialize, Serialize};
use std::{
    fs,
    io::ErrorKind,
    path::{Component, Path, PathBuf},
};
use umbrage_core::Invalid;

const FILE: &str = "run.json";

/// The comparison, and the part of it that was measured into a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) plan: ComparisonPlan,
    /// Indices in the plan: all of them, or a shard's.
    pub(super) places: Vec<usize>,
}

/// Reports whether a folder contains scenes, also those of versions that wrote no [`FILE`].
fn holds_scenes(folder: &Path) -> bool {
    let inside = fs::read_dir(folder).into_iter().flatten().flatten();
    inside
        .into_iter()
        .any(|entry| entry.path().join(store::FILE).is_file())
}

/// Reports whether a name is that of an entry directly inside a folder. Merging removes and writes
/// folders by the names in a file, which must not lead elsewhere.
fn is_inside(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let only = match (parts.next(), parts.next()) {
        (Some(Component::Normal(part)), None) => Some(part),
        _ => None,
    };
    only.is_some_and(|part| part == name)
}

impl Run {
    pub(super) fn write(&self, folder: &Folder) -> Result<(), LabError> {
        let json = serde_json::to_vec_pretty(self).map_err(|e| LabError::write(FILE, e))?;
        folder.write(FILE, &json)
    }

    /// Reads the last run of a folder. `writer` is the command that writes such folders, for
    /// errors.
    ///
    /// # Errors
    /// Errors if the folder has no run, or a damaged one.
    pub(super) fn read(folder: &Path, writer: &str) -> Result<Self, Invalid> {
        let what = format!("folder `{}`", folder.display());
        let help = format!("pass a folder that `{writer}` wrote");
        let bytes = match fs::read(folder.join(FILE)) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound && holds_scenes(folder) => {
                let why = format!("was not written by this version: it has no {FILE}");
                let help = format!("measure it again with `{writer}`");
                return Err(Invalid::new(what, why, help));
            }
            Err(e) => {
                let why = format!("contains no scenes ({FILE}: {e})");
                return Err(Invalid::new(what, why, help));
            }
        };
        let damaged =
            |why: String| Invalid::new(what, format!("has a damaged {FILE}: {why}"), help);
        let run: Self = match serde_json::from_slice(&bytes) {
            Ok(run) => run,
            Err(error) => return Err(damaged(error.to_string())),
        };
        match run.plan.scenes.iter().find(|name| !is_inside(name)) {
            Some(name) => Err(damaged(format!("no scene's folder can be `{name}`"))),
            None => Ok(run),
        }
    }

    /// Returns the run's existing scenes, each with its folder.
    ///
    /// # Errors
    /// Errors if one of them is damaged.
    pub(super) fn scenes(&self, folder: &Path) -> Result<Vec<(PathBuf, Stored)>, Invalid> {
        let mut out = Vec::new();
        for &place in &self.places {
            let Some(name) = self.plan.scenes.get(place) else {
                continue;
            };
            let path = folder.join(name);
            let stored = Stored::read(&path)?.filter(|s| s.place == place && s.plan == self.plan);
            out.extend(stored.map(|stored| (path, stored)));
        }
        Ok(out)
    }
}

/// A scene's results in a report's folder.
#[derive(Clone, Debug)]
pub(crate) struct MeasuredScene {
    /// Folder of its images.
    pub(crate) folder: PathBuf,
    /// Environment of the measurement.
    pub(crate) environment: Environment,
    /// Hash of the measuring program.
    pub(crate) program: String,
    pub(crate) result: SceneResult,
}

/// Returns the scenes of the last run in a report's folder.
///
/// # Errors
/// Errors if there are none, or one of them is damaged.
pub(crate) fn measured_scenes(report: &Path) -> Result<Vec<MeasuredScene>, Invalid> {
    let scenes = Run::read(report, "compare")?.scenes(report)?;
    if scenes.is_empty() {
        let what = format!("folder `{}`", report.display());
        let help = "pass the folder of a finished `compare`";
        return Err(Invalid::new(what, "contains no scenes", help));
    }
    let measured = scenes.into_iter().map(|(folder, stored)| MeasuredScene {
        folder,
        environment: stored.environment,
        program: stored.program,
        result: stored.result,
    });
    Ok(measured.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the result of reading a folder whose run names a scene.
    fn read(scene: &str) -> Result<Run, Invalid> {
        let plan = ComparisonPlan {
            schema: 0,
            options: String::new(),
            scenes: vec![scene.to_owned()],
            contents: vec![String::new()],
        };
        let run = Run {
            plan,
            places: vec![0],
        };
        let folder = tempfile::tempdir().expect("a folder");
        let json = serde_json::to_vec(&run).expect("written");
        fs::write(folder.path().join(FILE), json).expect("written");
        Run::read(folder.path(), "compare")
    }

    #[test]
    fn scenes_lie_inside_their_folder() {
        for name in ["cubes", "results.json-2", "ä", "_con", "x-"] {
            assert!(read(name).is_ok(), "{name}");
        }
        for name in ["", ".", "..", "../cubes", "/tmp/cubes", "a/b", "a/", "./a"] {
            let error = read(name).expect_err(name).to_string();
            assert!(error.contains("damaged"), "{error}");
        }
    }
}
