//! Scenes on disk: each is a folder that is written completely or not at all, so that a stopped
//! comparison loses nothing.

use crate::output::folder::Folder;
use crate::{
    compare::{CompareOptions, Environment, SCHEMA, SceneInput, SceneResult},
    error::LabError,
    output::{checksum, hash, slug},
};
use serde::{Deserialize, Serialize};
use std::{fs, io::ErrorKind, path::Path};
use umbrage_core::{Invalid, MAX_NAME_BYTES, Scene};

/// File that marks a folder as a scene's.
pub(super) const FILE: &str = "scene.json";

/// Plan of a whole comparison, over all shards. Results with equal plans belong together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComparisonPlan {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Full text of the options.
    pub options: String,
    /// Distinct folder names of all scenes, in order.
    pub scenes: Vec<String>,
    /// Hash of each scene and its contents.
    pub contents: Vec<String>,
}

impl ComparisonPlan {
    /// Returns the plan of all `inputs`, whichever of them this run measures.
    pub fn new(inputs: &[SceneInput], options: &CompareOptions) -> Self {
        let scenes = unique_names(inputs.iter().map(|i| i.scene.name.as_str()));
        let contents = inputs.iter().map(content_hash).collect();
        Self {
            schema: SCHEMA,
            options: format!("{options:?}"),
            scenes,
            contents,
        }
    }
}

/// Returns a hash of a scene and its options.
fn content_hash(input: &SceneInput) -> String {
    let SceneInput {
        scene,
        summary,
        fit,
        section,
        options,
    } = input;
    let Scene {
        name,
        meshes,
        instances,
        materials,
        textures,
        lights,
        cameras,
        anchor,
        notices,
    } = scene;
    // Hash texels as bytes: as text, each takes some 50 bytes, a gigabyte for a large texture.
    let textures: Vec<_> = textures
        .iter()
        .map(|texture| {
            let texels = &texture.texels;
            // Equal bytes of another encoding have other values.
            let encoding = std::mem::discriminant(texels);
            (
                &texture.name,
                texture.size,
                encoding,
                hash(texels.as_bytes()),
            )
        })
        .collect();
    let surfaces = (meshes, instances, materials, textures);
    let rest = (name, lights, cameras, anchor, notices);
    hash(&format!(
        "{surfaces:?} {rest:?} {summary:?} {fit:?} {section:?} {options:?}"
    ))
}

/// A scene's figures, and the data needed to reuse them later.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Stored {
    pub(super) plan: ComparisonPlan,
    /// Index of the scene in the plan.
    pub(super) place: usize,
    /// Hash of the measuring program: figures of another program are not reused.
    pub(super) program: String,
    pub(super) environment: Environment,
    pub(super) notices: Vec<String>,
    pub(super) result: SceneResult,
}

/// Text before the checksum. The file's first entry is the checksum of the rest, as sixteen
/// hexadecimal digits.
const BEFORE: &str = "{\n  \"checksum\": \"";
/// Text between the checksum and the rest.
const AFTER: &str = "\",\n";

impl Stored {
    /// Reads a folder; `None` if it has no scene.
    ///
    /// # Errors
    /// Errors if the figures are truncated or were changed.
    pub(super) fn read(folder: &Path) -> Result<Option<Self>, Invalid> {
        let path = folder.join(FILE);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(unusable_file(&path, format!("cannot be read: {e}"))),
        };
        let parts = text
            .strip_prefix(BEFORE)
            .and_then(|rest| rest.split_once(AFTER));
        let Some((expected, rest)) = parts else {
            let why = "has no checksum: it is truncated, or another version wrote it";
            return Err(unusable_file(&path, why));
        };
        let found = checksum(rest.as_bytes());
        if expected != found {
            let why =
                format!("was changed or truncated: its checksum is {found}, expected {expected}");
            return Err(unusable_file(&path, why));
        }
        // A complete file of this version is readable.
        serde_json::from_str(&text)
            .map(Some)
            .map_err(|e| unusable_file(&path, format!("is damaged: {e}")))
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

fn unusable_file(path: &Path, why: impl Into<String>) -> Invalid {
    Invalid::new(
        format!("`{}`", path.display()),
        why,
        "measure the scene again: run the same command, or remove the scene's folder",
    )
}

/// Names of the report's own files, which no scene's folder may have.
const OWN: [&str; 6] = [
    "index.html",
    "rows.csv",
    "work.csv",
    "overall.csv",
    "results.json",
    "run.json",
];

/// Reports whether a file of the report with this name is a chart.
pub(super) fn is_chart(name: &str) -> bool {
    let is_picture = name.ends_with(".svg") || name.ends_with(".png");
    name.starts_with("chart-") && is_picture
}

/// Returns a folder name for each scene, numbered if scenes share a name.
fn unique_names<'a>(scenes: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for scene in scenes {
        // Scenes with longer names are rejected, but lowercase letters may have more bytes than
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
