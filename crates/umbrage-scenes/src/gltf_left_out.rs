//! Substitute for the reader of glTF files without the feature `gltf`.

use crate::{Files, SceneError, model_part::ModelPart, scene_of_file::SceneOfFile};
use umbrage_core::Scene;

pub(crate) fn read_scene(wanted: &SceneOfFile, _: &dyn Files) -> Result<Scene, SceneError> {
    Err(left_out(wanted))
}

pub(crate) fn add(
    wanted: &SceneOfFile,
    _: &dyn Files,
    _has_looks: bool,
    _: &mut Scene,
) -> Result<Vec<ModelPart>, SceneError> {
    Err(left_out(wanted))
}

pub(crate) fn brings_light(wanted: &SceneOfFile, _: &dyn Files) -> Result<bool, SceneError> {
    Err(left_out(wanted))
}

fn left_out(wanted: &SceneOfFile) -> SceneError {
    SceneError::Unreadable {
        file: wanted.file.display().to_string(),
        why: "is a glTF file, which this program was built without".to_owned(),
        help: "build umbrage-scenes with its feature `gltf`, or export the model as .obj"
            .to_owned(),
    }
}
