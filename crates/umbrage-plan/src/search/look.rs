//! What settings look like: truth and masks at an even grid of the image's pixels, for pictures
//! beside a plan.

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

/// Rays a pixel of truth in pictures: their noise is a grey level or two.
const RAYS: u32 = 64;
/// Rays a pixel for finding out what is ambiguous.
const PROBE_RAYS: u32 = 8;

/// Truth and masks for pictures. Pixels are every so many-th of the image's rows and columns, as
/// they are: nothing is averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Width and height, pixels of the grid.
    pub size: UVec2,
    /// What each of them is.
    pub pixels: Vec<Pixel>,
    /// Truth there, from few rays: to be looked at, not to be measured by.
    pub truth: Vec<f32>,
    /// The mask of each preset; none where it can't be played.
    pub masks: Vec<Option<Vec<f32>>>,
}

/// Renders presets for the first camera of the options (or the scene) and its light, at a grid at
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
        // Few rays differ by chance alone.
        ambiguous_change: 0.5,
        ..options.truth
    };
    let truth = seen.truth_at(&grid, &few, &|done, total| {
        on_step(Step::Truth(done, total))
    })?;
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
        // What receives is what receives at every third row and column of the image.
        let camera = scene.cameras[0].resized(UVec2::new(161, 120));
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
                "rays are truth under an ideal light"
            );
        }
        assert_eq!(seen(RendererData::CasterBox).masks[1], None);
    }
}
