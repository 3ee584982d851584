//! Images of settings for display with a plan: truth and masks at an even grid of the image's
//! pixels.

use super::options::PlanOptions;
use crate::{
    error::MeasureError,
    estimate::scene::{PlanScene, RendererData},
    progress::{OnStep, Step},
    truth::TruthOptions,
};
use glam::UVec2;
use umbrage_core::{Geometry, Scene, metrics::Pixel};
use umbrage_techniques::TechniquePreset;

/// Rays a pixel of truth in preview images. Their noise is one or two grey levels.
const RAYS: u32 = 64;
/// Rays a pixel for finding ambiguous pixels.
const PROBE_RAYS: u32 = 8;

/// Truth and masks for preview images. The pixels are every n-th of the image's rows and columns,
/// without averaging.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Width and height, pixels of the grid.
    pub size: UVec2,
    /// Class of each pixel.
    pub pixels: Vec<Pixel>,
    /// Truth of each pixel, from few rays: precise enough for display, not for measurement.
    pub truth: Vec<f32>,
    /// Mask of each preset; `None` if it can't be executed.
    pub masks: Vec<Option<Vec<f32>>>,
}

/// Renders presets for the first camera of the options (or the scene) and its light. The grid is at
/// most `max_width` pixels wide.
///
/// # Errors
/// Errors if the scene has no camera or light, or is not valid.
pub fn look(
    scene: &Scene,
    presets: &[TechniquePreset],
    renderer: RendererData,
    options: &PlanOptions,
    max_width: u32,
    on_step: &OnStep<'_>,
) -> Result<Look, MeasureError> {
    let light = options.light_of(scene)?;
    let cameras = options.cameras_of(scene)?;
    let geometry = Geometry::bake(scene)?;
    let mut seen = PlanScene::new(&cameras[0], light, &geometry, options.weighting)?;
    seen.make_recipes_from(renderer);
    // Choose the grid.
    let full = seen.receivers.size;
    let step = full.x.div_ceil(max_width.max(1)).max(1);
    let size = UVec2::new(full.x.div_ceil(step), full.y.div_ceil(step));
    let grid: Vec<u32> = (0..size.x * size.y)
        .map(|i| (i / size.x * step) * full.x + i % size.x * step)
        .collect();
    let few = TruthOptions {
        samples: RAYS.min(options.truth.samples),
        penumbra_factor: 1,
        probe_samples: PROBE_RAYS,
        // With few rays, values differ by chance alone.
        ambiguous_change: 0.5,
        ..options.truth
    };
    let truth = seen.truth_at(&grid, &few, &|done, total| {
        on_step(Step::Truth(done, total))
    })?;
    // Evaluate each preset at the grid.
    let mut masks = Vec::new();
    for preset in presets {
        let mask = match seen.recipe(preset) {
            Ok(recipe) => Some(seen.mask_at(&recipe, &grid)?),
            Err(_) => None,
        };
        masks.push(mask);
    }
    Ok(Look {
        size,
        pixels: truth.iter().map(|t| t.pixel).collect(),
        truth: truth.iter().map(|t| t.visibility).collect(),
        masks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_techniques::{Traced, Unshadowed};

    #[test]
    fn pictures_show_pixels_of_the_image_itself() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let options = PlanOptions {
            size: Some(UVec2::new(161, 120)),
            ..PlanOptions::default()
        };
        let presets = [Unshadowed::default().into(), Traced::default().into()];
        let seen = |renderer| {
            look(&scene, &presets, renderer, &options, 80, &|_| {}).expect("can be rendered")
        };
        let found = seen(RendererData::Triangles);
        assert_eq!(
            (found.size, found.truth.len()),
            (UVec2::new(54, 40), 54 * 40)
        );
        // The grid's receivers are those at every third row and column of the image.
        let camera = scene.cameras[0].with_size(UVec2::new(161, 120));
        let geometry = Geometry::bake(&scene).expect("valid");
        let whole = umbrage_cpu::Cpu::new()
            .receivers(&camera, &geometry)
            .expect("valid");
        for (i, pixel) in found.pixels.iter().enumerate() {
            let place = i / 54 * 3 * 161 + i % 54 * 3;
            assert_eq!(*pixel == Pixel::Empty, !whole.receives[place], "{i}");
        }
        let masks: Vec<&Vec<f32>> = found.masks.iter().flatten().collect();
        let counted: Vec<usize> = (0..found.truth.len())
            .filter(|&i| found.pixels[i] == Pixel::Counted)
            .collect();
        assert!(counted.len() > 500 && counted.iter().any(|&i| found.truth[i] == 0.0));
        for i in counted {
            assert_eq!(masks[0][i], 1.0, "no shadow is light");
            assert_eq!(
                masks[1][i], found.truth[i],
                "rays equal truth under an ideal light"
            );
        }
        assert_eq!(seen(RendererData::CasterBox).masks[1], None);
    }
}
