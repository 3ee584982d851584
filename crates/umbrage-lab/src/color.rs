//! Colour images of scenes: Blinn-Phong shading with a marker at the light.

use crate::{error::LabError, output::png::encode_rgb};
use glam::UVec2;
use umbrage_core::{
    Fit, Geometry, Invalid, LightMarker, Receivers, Recipe, RecipeError, Scene, ShadowTechnique,
    Shadows, View,
};
use umbrage_techniques::{BlinnPhong, Shading};

/// A scene with a marker at its light, to shade with any technique's shadows.
#[derive(Clone, Debug)]
pub(crate) struct ColorScene {
    scene: Scene,
    geometry: Geometry,
    shading: Shading,
}

impl ColorScene {
    /// Prepares a scene with a light and a camera. The marker of a directional light is at the eye
    /// of the scene's fit, if it has one.
    pub(crate) fn new(scene: Scene, fit: Option<Fit>) -> Result<Self, Invalid> {
        let directional_at = match fit {
            Some(Fit::Manual { eye, .. }) => Some(eye),
            _ => None,
        };
        let scene = scene.with_light_marker(LightMarker {
            directional_at,
            ..LightMarker::default()
        });
        let geometry = Geometry::bake(&scene)?;
        let view = view(&scene, &geometry)?;
        let shading = BlinnPhong::default().shading(&scene, &view)?;
        Ok(Self {
            scene,
            geometry,
            shading,
        })
    }

    /// Returns the view of the scene's camera and light.
    pub(crate) fn view(&self) -> Result<View<'_>, Invalid> {
        view(&self.scene, &self.geometry)
    }

    /// Returns a technique's recipe that also shades. `receivers` are those of the scene without
    /// the marker.
    pub(crate) fn recipe(
        &self,
        technique: &dyn ShadowTechnique,
        receivers: &Receivers,
    ) -> Result<Recipe, RecipeError> {
        let view = self.view()?.with_receivers(receivers);
        let recipe = technique.recipe(&view)?;
        Ok(self.shading.add_to(recipe))
    }
}

fn view<'a>(scene: &'a Scene, geometry: &'a Geometry) -> Result<View<'a>, Invalid> {
    let (Some(camera), Some(light)) = (scene.cameras.first(), scene.lights.first()) else {
        return Err(Invalid::new(
            format!("scene `{}`", scene.name),
            "has no camera or no light",
            "add one",
        ));
    };
    Ok(View::new(camera, light, geometry))
}

/// Returns the shaded image as a PNG. `None` if the recipe didn't shade.
pub(crate) fn png(size: UVec2, shadows: &Shadows) -> Option<Result<Vec<u8>, LabError>> {
    shadows.picture_bytes().map(|rgb| encode_rgb(size, &rgb))
}

/// Returns the number of pixels with different colours: by more than one step of 255, though masks
/// agree within one step and both show the same triangle. `None` if either has no image.
pub(crate) fn count_differing(a: &Shadows, b: &Shadows) -> Option<u64> {
    let a_colors = a.picture_bytes()?;
    let b_colors = b.picture_bytes()?;
    let color_pairs = a_colors.chunks(3).zip(b_colors.chunks(3));
    let mut count = 0;
    for (i, (a_color, b_color)) in color_pairs.enumerate() {
        let have_same_mask = (a.mask[i] - b.mask[i]).abs() <= 1.0 / 255.0;
        let have_same_triangle = triangle(a, i) == triangle(b, i);
        let differ_in_color = a_color.iter().zip(b_color).any(|(v, w)| v.abs_diff(*w) > 1);
        count += u64::from(have_same_mask && have_same_triangle && differ_in_color);
    }
    Some(count)
}

/// Returns the triangle of a pixel. `None` if the backend doesn't report its receivers.
fn triangle(shadows: &Shadows, pixel: usize) -> Option<u32> {
    let receivers = shadows.receivers.as_ref()?;
    Some(receivers.triangle[pixel])
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::Timings;

    fn shadows(mask: [f32; 2], colors: [f32; 2]) -> Shadows {
        Shadows {
            size: UVec2::new(2, 1),
            mask: mask.to_vec(),
            receivers: None,
            picture: Some(colors.map(|c| [c, c, c, 1.0]).to_vec()),
            images: Vec::new(),
            timings: Timings::default(),
            bytes: 0,
        }
    }

    #[test]
    fn colours_must_agree_where_masks_do() {
        let a = shadows([1.0, 0.0], [0.5, 0.1]);
        assert_eq!(
            count_differing(&a, &shadows([1.0, 0.0], [0.5, 0.1])),
            Some(0)
        );
        assert_eq!(
            count_differing(&a, &shadows([1.0, 0.0], [0.6, 0.1])),
            Some(1),
            "a spoilt colour"
        );
        assert_eq!(
            count_differing(&a, &shadows([1.0, 1.0], [0.5, 0.9])),
            Some(0),
            "masks differ there: no error of shading"
        );
        assert_eq!(
            count_differing(
                &a,
                &Shadows {
                    picture: None,
                    ..a.clone()
                }
            ),
            None
        );
    }
}
