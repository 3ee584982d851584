//! What a folder's last run is about. Scenes of other runs may lie beside its own, and are none of its business.

use super::store::{self, ComparisonPlan, Stored};
use crate::{LabError, output::Folder};
use serde::{Deserialize, Serialize};
use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};
use umbrage_core::Invalid;

const FILE: &str = "run.json";

/// The comparison, and the part of it that was measured into a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) plan: ComparisonPlan,
    /// Places in the plan, from 0: all of them, or a shard's.
    pub(super) places: Vec<usize>,
}

/// Whether a folder has scenes in it, as those have that versions without a [`FILE`] wrote.
fn holds_scenes(folder: &Path) -> bool {
    let inside = fs::read_dir(folder).into_iter().flatten().flatten();
    inside
        .into_iter()
        .any(|entry| entry.path().join(store::FILE).is_file())
}

impl Run {
    pub(super) fn write(&self, folder: &Folder) -> Result<(), LabError> {
        folder.write(
            FILE,
            &serde_json::to_vec_pretty(self).map_err(|e| LabError::write(FILE, e))?,
        )
    }

    pub(super) fn read(folder: &Path) -> Result<Self, Invalid> {
        let refuse = |why: String| {
            Invalid::new(
                format!("folder `{}`", folder.display()),
                why,
                "give folders that `compare --shard` wrote",
            )
        };
        let bytes = fs::read(folder.join(FILE)).map_err(|e| match e.kind() {
            ErrorKind::NotFound if holds_scenes(folder) => Invalid::new(
                format!("folder `{}`", folder.display()),
                format!("was not written by this version: it has no {FILE}"),
                "measure it again with `compare --shard`",
            ),
            _ => refuse(format!("holds no scenes ({FILE}: {e})")),
        })?;
        serde_json::from_slice(&bytes).map_err(|e| refuse(format!("has a damaged {FILE}: {e}")))
    }

    /// The run's scenes that are there.
    ///
    /// # Errors
    /// Errors if one of them is damaged.
    pub(super) fn scenes(&self, folder: &Path) -> Result<Vec<(PathBuf, Stored)>, Invalid> {
        let mut out = Vec::new();
        for &place in &self.places {
            let Some(path) = self.plan.scenes.get(place).map(|name| folder.join(name)) else {
                continue;
            };
            let stored = Stored::read(&path)?.filter(|s| s.place == place && s.plan == self.plan);
            out.extend(stored.map(|stored| (path, stored)));
        }
        Ok(out)
    }
}
