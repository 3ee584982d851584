//! Scene files.

mod camera;
mod cameras;
#[cfg(all(test, feature = "gltf"))]
mod gltf_tests;
mod light;
mod look;
mod numbers;
mod object;
mod table;
#[cfg(test)]
mod tests;

pub use cameras::cameras;

use crate::{Files, SceneError, error::Place, obj};
use std::{
    io::{self, Read as _},
    path::Path,
};
use table::{Table, TextSource};
use toml::de::DeTable;
use umbrage_core::{Anchor, Geometry, Light, MAX_NAME_BYTES, Scene};

/// Greatest length of a scene file, bytes.
const LONGEST: u64 = 16 << 20;

/// Reads the scene file at `path` among `files`.
pub(crate) fn read(path: &Path, files: &dyn Files) -> Result<Scene, SceneError> {
    let text = text_of(path, files)?;
    parse(&text, path, path.parent().unwrap_or(Path::new("")), files)
}

/// Returns the text of a scene or camera file.
fn text_of(path: &Path, files: &dyn Files) -> Result<String, SceneError> {
    let read = || {
        let mut text = String::new();
        let source = files.open(path)?;
        // Read one more byte, to detect longer files.
        if source.take(LONGEST + 1).read_to_string(&mut text)? as u64 > LONGEST {
            return Err(io::Error::other("is over 16 MiB long"));
        }
        Ok(text)
    };
    read().map_err(|e| SceneError::unreadable_file(path, &e, files))
}

/// Returns the error of a text that is not TOML.
fn syntax(source: &TextSource<'_>, e: &toml::de::Error) -> SceneError {
    source.fault(
        e.span().unwrap_or(0..0),
        None,
        e.message().trim(),
        "see https://toml.io for the syntax",
    )
}

/// Reads a scene from a text. `path` is the name of its file. Paths in the text are relative to
/// `folder`.
pub(crate) fn parse(
    text: &str,
    path: &Path,
    folder: &Path,
    files: &dyn Files,
) -> Result<Scene, SceneError> {
    let source = TextSource {
        file: path.display().to_string(),
        text,
    };
    // Parse the text, and check the keys.
    let document = DeTable::parse(text).map_err(|e| syntax(&source, &e))?;
    let root = Table::root(&source, &document);
    root.only(&["name", "anchor", "camera", "light", "object"])?;
    let anchor = root.anchor()?;
    let mut scene = Scene {
        name: obj::name_of(path),
        ..Scene::default()
    };
    // Read the name.
    if let Some(name) = root.get("name") {
        scene.name = name.text()?.to_owned();
        name.require(
            !scene.name.trim().is_empty(),
            "is empty",
            "give the scene a name, or leave it out",
        )?;
        let length = scene.name.len();
        let help = format!("use at most {MAX_NAME_BYTES}: reports use it as the name of a folder");
        name.require(
            length <= MAX_NAME_BYTES,
            &format!("is {length} bytes long"),
            &help,
        )?;
    }
    // Read lights, objects and the camera, in this order.
    let lights = root.tables("light")?;
    let lights = |anchor: Anchor| -> Result<Vec<Light>, SceneError> {
        lights
            .iter()
            .map(|table| light::read(table, anchor))
            .collect()
    };
    scene.lights = lights(anchor.unwrap_or(Anchor::ORIGIN))?;
    root.require(
        !scene.lights.is_empty(),
        "has no [[light]]",
        "add one with kind = \"directional\" and a direction",
    )?;
    let objects = root.tables("object")?;
    root.require(
        !objects.is_empty(),
        "has no [[object]]",
        "add one with shape = \"box\" or mesh = \"model.obj\"",
    )?;
    let eye = root.table("camera")?.and_then(|camera| camera.get("eye"));
    let eye = eye.and_then(|eye| eye.wide_vec3().ok());
    let chosen = anchor.ok_or(eye);
    let anchor = object::read_all(&objects, folder, files, chosen, &mut scene)?;
    // Objects determine the anchor of files without one.
    scene.lights = lights(anchor)?;
    scene.anchor = anchor;
    add_camera(&root, anchor, &mut scene)?;
    Ok(scene)
}

fn add_camera(root: &Table<'_>, anchor: Anchor, scene: &mut Scene) -> Result<(), SceneError> {
    let invalid = |fault| SceneError::Invalid {
        file: root.source.file.clone(),
        fault,
    };
    let geometry = Geometry::bake(scene).map_err(invalid)?;
    let camera = match root.table("camera")? {
        Some(table) => camera::read(&table, &geometry, anchor)?,
        None => obj::framing_camera(
            &geometry,
            Place {
                file: root.source.file.clone(),
                line: None,
                key: None,
            },
        )?,
    };
    scene.cameras.push(camera);
    scene.validate().map_err(invalid)
}
