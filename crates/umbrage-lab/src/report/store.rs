//! Scenes on disk: each is a folder that is written whole or not at all, so that a stopped
//! comparison loses nothing.

use crate::output::folder::Folder;
use crate::{
    compare::{CompareOptions, Environment, SCHEMA, SceneInput, SceneResult},
    error::LabError,
    output::{checksum, hash, slug},
};
use serde::{Deserialize, Serialize};
use std::{fs, io::ErrorKind, path::Path};
use umbrage_core::{Invalid, MAX_NAME_BYTES};

/// The file that makes a folder a scene's.
pub(super) const FILE: &str = "scene.json";

/// What a whole comparison compares, all shards together. Results of equal plans belong together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComparisonPlan {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The options, in full.
    pub options: String,
    /// Folder names of all scenes, in order; no two alike.
    pub scenes: Vec<String>,
    /// A hash of each scene with all that is in it.
    pub contents: Vec<String>,
}

impl ComparisonPlan {
    /// The plan of all `inputs`, whichever of them this run is to measure.
    pub fn new(inputs: &[SceneInput], options: &CompareOptions) -> Self {
        let scenes = unique_names(inputs.iter().map(|i| i.scene.name.as_str()));
        let contents = inputs.iter().map(|i| hash(&format!("{i:?}"))).collect();
        Self {
            schema: SCHEMA,
            options: format!("{options:?}"),
            scenes,
            contents,
        }
    }
}

/// A scene's figures with all that is needed to take them up later.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Stored {
    pub(super) plan: ComparisonPlan,
    /// The scene's place in the plan, from 0.
    pub(super) place: usize,
    /// Hash of the program that measured: another program's figures are not taken up.
    pub(super) program: String,
    pub(super) environment: Environment,
    pub(super) notices: Vec<String>,
    pub(super) result: SceneResult,
}

/// What the file begins with: the checksum of all that follows is its first entry, as sixteen
/// hexadecimal digits.
const BEFORE: &str = "{\n  \"checksum\": \"";
/// What stands between the checksum and the rest.
const AFTER: &str = "\",\n";

impl Stored {
    /// Reads a folder; none if it holds no scene.
    ///
    /// # Errors
    /// Errors if the figures are not whole, or not as they were written.
    pub(super) fn read(folder: &Path) -> Result<Option<Self>, Invalid> {
        let path = folder.join(FILE);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(unusable(&path, format!("cannot be read: {e}"))),
        };
        let parts = text
            .strip_prefix(BEFORE)
            .and_then(|rest| rest.split_once(AFTER));
        let Some((expected, rest)) = parts else {
            let why = "has no checksum: it is not whole, or another version wrote it";
            return Err(unusable(&path, why));
        };
        let found = checksum(rest.as_bytes());
        if expected != found {
            let why = format!(
                "was changed since it was written, or is not whole: its checksum is {found}, it says {expected}"
            );
            return Err(unusable(&path, why));
        }
        // What was written by this version and is whole can be read.
        serde_json::from_str(&text)
            .map(Some)
            .map_err(|e| unusable(&path, format!("is damaged: {e}")))
    }

    pub(super) fn write(&self, folder: &Folder) -> Result<(), LabError> {
        let text = serde_json::to_string_pretty(self).map_err(|e| LabError::write(FILE, e))?;
        let rest = text.strip_prefix("{\n").unwrap_or(&text);
        let checksum = checksum(rest.as_bytes());
        let file = format!("{BEFORE}{checksum}{AFTER}{rest}");
        folder.write(FILE, file.as_bytes())
    }

    /// Returns the folder's name.
    pub(super) fn name(&self) -> &str {
        self.plan.scenes.get(self.place).map_or("", String::as_str)
    }
}

fn unusable(path: &Path, why: impl Into<String>) -> Invalid {
    Invalid::new(
        format!("`{}`", path.display()),
        why,
        "measure the scene again: run the same command, or remove the scene's folder",
    )
}

/// The report's own files: no scene's folder may have their names.
const OWN: [&str; 6] = [
    "index.html",
    "rows.csv",
    "work.csv",
    "overall.csv",
    "results.json",
    "run.json",
];

/// Whether a file of the report with this name is a chart.
pub(super) fn is_chart(name: &str) -> bool {
    let is_picture = name.ends_with(".svg") || name.ends_with(".png");
    name.starts_with("chart-") && is_picture
}

/// Returns a folder name for each scene, numbered where scenes share a name.
fn unique_names<'a>(scenes: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for scene in scenes {
        // Scenes with longer names are refused; but lowercase letters may take more bytes than
        // uppercase ones.
        let mut stem = slug(scene);
        stem.truncate(stem.floor_char_boundary(MAX_NAME_BYTES));
        let mut name = stem.clone();
        if is_chart(&name) {
            stem = format!("scene-{stem}");
            name.clone_from(&stem);
        }
        let mut number = 2;
        while names.contains(&name) || OWN.contains(&name.as_str()) {
            name = format!("{stem}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::unique_names;

    #[test]
    fn folders_have_names_of_their_own() {
        let names = [
            "Sun",
            "sun",
            "results.json",
            "con",
            "x.",
            "Ä",
            "ä",
            "chart-room",
            "chart-x.svg",
        ];
        let folders = unique_names(names.into_iter());
        assert_eq!(
            folders,
            [
                "sun",
                "sun-2",
                "results.json-2",
                "_con",
                "x",
                "ä",
                "ä-2",
                "chart-room",
                "scene-chart-x.svg"
            ]
        );
    }
}
