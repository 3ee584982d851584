//! Tests with files from [`model`], which are read like any file.

mod errors;
mod geometry;
mod looks;
pub(crate) mod model;
mod mutated;
mod poses;
mod scenes;

use super::{SceneOfFile, read};
use crate::FilesInMemory;
use base64::{Engine as _, engine::general_purpose::STANDARD};
use model::TestModel;
use std::path::Path;
use umbrage_core::{Invalid, Scene};

/// Reads a file with some others next to it, without the additions for a lone model.
fn read_plain(path: &str, files: &FilesInMemory) -> Result<Scene, Invalid> {
    let wanted = SceneOfFile::of_path(Path::new(path)).expect("a glTF file");
    let bytes = files.bytes_of(&wanted.file);
    read(&bytes, &wanted, files)
}

/// Reads a model with each kind of buffer: in a chunk, in a data URI, in a separate file.
fn scene_of(model: &TestModel) -> Result<Scene, String> {
    let read = |file: &str, bytes: Vec<u8>| {
        let files = [(file, bytes), ("b in.bin", model.bytes.clone())];
        read_plain(file, &files.into_iter().collect()).map_err(|e| e.to_string())
    };
    let in_chunk = read("model.glb", model.glb());
    let data = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(&model.bytes)
    );
    for uri in [data.as_str(), "b%20in.bin"] {
        let apart = read("model.gltf", model.text(Some(uri)).into_bytes());
        match (&in_chunk, &apart) {
            (Ok(in_chunk), Ok(apart)) => assert_eq!(in_chunk, &with_notices_of_glb(apart), "{uri}"),
            // Limits depend on the length of all files together.
            (Err(in_chunk), Err(apart)) if in_chunk.contains("would make") => {
                assert!(apart.contains("would make"), "{apart}");
            }
            (Err(in_chunk), Err(apart)) => assert_eq!(in_chunk, apart),
            _ => panic!("in a chunk: {in_chunk:?}, as {uri}: {apart:?}"),
        }
    }
    in_chunk
}

/// Returns the scene of `model.gltf` with notices that name `model.glb`.
fn with_notices_of_glb(scene: &Scene) -> Scene {
    let renamed = |notice: &String| notice.replacen("model.gltf: ", "model.glb: ", 1);
    Scene {
        notices: scene.notices.iter().map(renamed).collect(),
        ..scene.clone()
    }
}
