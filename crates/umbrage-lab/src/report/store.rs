//! Scenes on disk: each is a folder that is there whole or not at all, so that a stopped comparison loses nothing.

use super::files::Folder;
use crate::{
    LabError,
    compare::{Environment, Options, SCHEMA, SceneInput, SceneResult, slug},
};
use serde::{Deserialize, Serialize};
use std::{
    fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::Path,
};

/// The file that makes a folder a scene's.
pub(super) const FILE: &str = "scene.json";

/// What a whole comparison is about, all shards together: equal plans make results that belong together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The options, in full.
    pub options: String,
    /// Folder names of all scenes, in order; no two alike.
    pub scenes: Vec<String>,
    /// A hash of each scene with all that is in it.
    pub contents: Vec<String>,
}

impl Plan {
    /// The plan of all `inputs`, whichever of them this run is to measure.
    pub fn new(inputs: &[SceneInput], options: &Options) -> Self {
        let scenes = unique_names(inputs.iter().map(|i| i.scene.name.as_str()));
        let contents = inputs.iter().map(|i| hash(&format!("{i:?}"))).collect();
        Self { schema: SCHEMA, options: format!("{options:?}"), scenes, contents }
    }
}

/// A scene's figures with all that is needed to take them up later.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Stored {
    pub(super) plan: Plan,
    /// The scene's place in the plan, from 0.
    pub(super) place: usize,
    /// Hash of the program that measured: another program's figures are not taken up.
    pub(super) program: String,
    pub(super) environment: Environment,
    pub(super) notices: Vec<String>,
    pub(super) result: SceneResult,
}

impl Stored {
    /// Reads a folder; none if it holds no scene, or a damaged one.
    pub(super) fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&fs::read(folder.join(FILE)).ok()?).ok()
    }

    pub(super) fn write(&self, folder: &Folder) -> Result<(), LabError> {
        let broken = |e: serde_json::Error| LabError::Write { path: FILE.into(), source: e.into() };
        folder.write(FILE, &serde_json::to_vec_pretty(self).map_err(broken)?)
    }

    /// The folder's name.
    pub(super) fn name(&self) -> &str {
        self.plan.scenes.get(self.place).map_or("", String::as_str)
    }
}

/// A hash of the program that runs; empty if the system doesn't say where it is.
pub(super) fn program() -> String {
    std::env::current_exe().and_then(fs::read).map(|bytes| hash(&bytes)).unwrap_or_default()
}

fn hash<T: Hash + ?Sized>(value: &T) -> String {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// File names, numbered where scenes share a name.
fn unique_names<'a>(scenes: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for stem in scenes.map(slug) {
        let numbered = (2..).map(|n| format!("{stem}-{n}"));
        let free = |name: &String| !names.contains(name);
        let name = std::iter::once(stem.clone()).chain(numbered).find(free).unwrap_or(stem);
        names.push(name);
    }
    names
}
