//! WGSL text of techniques, to paste into a shader.

use crate::error::LabError;
use umbrage_core::{Geometry, Invalid, RecipeError, ShadowTechnique, View, glam::UVec2};
use umbrage_wgpu::receive_wgsl;

/// Scenes with a sun and with an area light, for techniques that support either.
const SCENES: [&str; 2] = ["cubes", "lamp-in-room"];

/// Returns the text of a technique for the first of a sun and an area light that it supports. All
/// names in the text begin with `prefix`. Its bindings are in group 0.
///
/// # Errors
/// Errors if the technique supports neither light, its settings are invalid, or the prefix can't
/// begin a name.
pub fn assembled_wgsl(technique: &dyn ShadowTechnique, prefix: &str) -> Result<String, LabError> {
    let mut why = None;
    for name in SCENES {
        let entry = umbrage_scenes::find(name).expect("a built-in scene");
        let mut scene = (entry.build)();
        // Use a small image: texts don't depend on the size, and small recipes are faster to make.
        scene.cameras[0].size = UVec2::splat(16);
        let geometry = Geometry::bake(&scene)?;
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        match technique.recipe(&view) {
            Ok(recipe) => {
                let text = receive_wgsl(&recipe, 0, prefix)?;
                return Ok(format!("{}\n", text.trim_end()));
            }
            Err(RecipeError::Unsupported(reason)) => why = Some(reason),
            Err(error) => return Err(error.into()),
        }
    }
    let why = format!(
        "supports neither a sun nor an area light ({})",
        why.unwrap_or_default()
    );
    Err(Invalid::new(technique.name(), why, "call `receive_wgsl` with its recipe").into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_techniques::{Hard, MapTechnique};

    #[test]
    fn a_prefix_begins_each_name() {
        let text = assembled_wgsl(&MapTechnique::<Hard>::default(), "sun_").expect("served");
        assert!(text.contains("fn sun_receive(r: sun_Receiver) -> f32"));
        let error = assembled_wgsl(&MapTechnique::<Hard>::default(), "1_").expect_err("no name");
        assert!(error.to_string().contains("prefix"), "{error}");
    }
}
