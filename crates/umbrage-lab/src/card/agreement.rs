//! Agreement of an adapter's masks with the CPU's.

use super::data::{CardAgreement, built_in};
use crate::{
    compare::{Backends, CompareOptions, SceneInput, compare},
    error::LabError,
};
use glam::UVec2;
use std::collections::BTreeMap;
use umbrage_core::{
    Backend, Geometry, Invalid, Recipe, RecipeError, Scene, ShadowTechnique, Shadows, View,
};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::TruthOptions;
use umbrage_techniques::{Exact, ExactStructure, Soft, Traced, Unshadowed};

/// Built-in scenes with all kinds of light (ideal, area, far from the origin, grazing) and
/// alpha-tested casters.
pub const BIT_SCENES: [&str; 15] = [
    "cubes",
    "stairs",
    "stairs-lamp",
    "sun-above",
    "spot-above",
    "lamp-in-room",
    "bar-at-lamp",
    "canopy",
    "two-blockers",
    "rising-boxes-disc",
    "low-sun-2",
    "hills-1e5",
    "hills-1e6",
    "open-shells",
    "c3-sphere-bulb",
];

/// Width of the images for the comparison of bits, pixels.
const WIDTH: u32 = 240;

/// Returns the techniques whose results don't depend on a rasteriser. They are functions of the
/// receivers only, with the same bits on every device that rounds sums and products to nearest.
pub fn exact_techniques() -> [Box<dyn ShadowTechnique>; 5] {
    [
        Box::new(Unshadowed::default()),
        Box::new(Traced { samples: 8 }),
        Box::new(Exact::default()),
        Box::new(Exact {
            structure: ExactStructure::Hierarchy,
        }),
        Box::new(Soft::default()),
    ]
}

/// Counts of a mask's pixels by agreement of two backends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BitCounts {
    /// Pixels where both see the same triangle.
    pub same_triangle: u64,
    /// Pixels where they see different triangles.
    pub other_triangle: u64,
    /// Pixels of the same triangle whose masks have different bits.
    pub other_bits: u64,
}

impl BitCounts {
    /// Counts the pixels of two renderings of a view. Both have their own receivers.
    pub fn between_masks(mine: &Shadows, theirs: &Shadows) -> Self {
        let mut counts = Self::default();
        let (Some(seen), Some(other)) = (&mine.receivers, &theirs.receivers) else {
            return counts;
        };
        for (i, (a, b)) in mine.mask.iter().zip(&theirs.mask).enumerate() {
            if seen.triangle[i] == other.triangle[i] {
                counts.same_triangle += 1;
                counts.other_bits += u64::from(a.to_bits() != b.to_bits());
            } else {
                counts.other_triangle += 1;
            }
        }
        counts
    }
}

/// Renderings of a recipe by two backends.
#[derive(Debug)]
pub struct BitPair<'a> {
    /// The scene's name.
    pub scene: &'a str,
    /// The technique's name.
    pub technique: &'a str,
    /// The view.
    pub view: View<'a>,
    /// The recipe.
    pub recipe: &'a Recipe,
    /// Result of the CPU.
    pub of_cpu: Shadows,
    /// Result of the other backend.
    pub of_device: Shadows,
}

/// Renders [`BIT_SCENES`] with [`exact_techniques`] on the CPU and on a backend, and passes each
/// pair to `on_pair`.
///
/// # Errors
/// Errors if a backend or a technique fails.
pub fn compare_bits(
    backend: &mut dyn Backend,
    on_pair: &mut dyn FnMut(BitPair<'_>),
) -> Result<(), LabError> {
    for name in BIT_SCENES {
        let scene = small_scene(name)?;
        let geometry = Geometry::bake(&scene)?;
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for technique in exact_techniques() {
            let recipe = match technique.recipe(&view) {
                Ok(recipe) => recipe,
                // `soft` doesn't support ideal lights, and `exact` no area lights.
                Err(RecipeError::Unsupported(_)) => continue,
                Err(e) => return Err(e.into()),
            };
            on_pair(BitPair {
                scene: name,
                technique: technique.name(),
                view,
                recipe: &recipe,
                of_cpu: Cpu::new().render(&view, &recipe)?,
                of_device: backend.render(&view, &recipe)?,
            });
        }
    }
    Ok(())
}

/// Returns a built-in scene with a camera that is [`WIDTH`] pixels wide.
fn small_scene(name: &str) -> Result<Scene, Invalid> {
    let mut scene = (built_in(name)?.build)();
    for camera in &mut scene.cameras {
        let height = (WIDTH * camera.size.y / camera.size.x).max(1);
        *camera = camera.with_size(UVec2::new(WIDTH, height));
    }
    Ok(scene)
}

/// Compares an adapter's masks with the CPU's: bits of exact techniques, and decided pixels of all
/// techniques. `backends` are the CPU and the adapter.
///
/// # Errors
/// Errors if a backend fails, or if there is no adapter among them.
pub fn measure_agreement(backends: &mut Backends) -> Result<CardAgreement, LabError> {
    let mut out = CardAgreement::default();
    let mut other_triangle = 0;
    let mut compared: BTreeMap<String, u64> = BTreeMap::new();
    let Some(device) = backends.backends.iter_mut().find(|b| b.kind() != "cpu") else {
        let help = "open them with `Backends::both`";
        return Err(Invalid::new("backends", "have no graphics adapter", help).into());
    };
    // Compare the bits of exact techniques.
    compare_bits(&mut **device, &mut |pair| {
        let counts = BitCounts::between_masks(&pair.of_cpu, &pair.of_device);
        other_triangle += counts.other_triangle;
        // Skip techniques without pixels: 0 of none would look like agreement.
        if counts.same_triangle > 0 {
            let technique = || pair.technique.to_owned();
            *compared.entry(technique()).or_default() += counts.same_triangle;
            *out.differing_bits.entry(technique()).or_default() += counts.other_bits;
        }
    })?;
    out.same_triangle_pixels = Some(compared.values().sum());
    out.other_triangle_pixels = Some(other_triangle);
    out.compared_pixels = Some(compared);
    // Compare the decided pixels of all techniques.
    let mut inputs = Vec::new();
    for name in BIT_SCENES {
        let entry = built_in(name)?;
        inputs.push(SceneInput {
            fit: entry.fit,
            ..SceneInput::new((entry.build)(), "")
        });
    }
    let options = CompareOptions {
        // Use few rays: agreement is reported, errors aren't.
        truth: TruthOptions {
            samples: 16,
            probe_samples: 8,
            penumbra_factor: 1,
            ..TruthOptions::default()
        },
        runs: None,
        max_settings: Some(2),
        ..CompareOptions::quick()
    };
    let comparison = compare(&inputs, &options, backends, &mut |_, _| Ok(()), &|_| {})?;
    let rows = comparison.scenes.iter().flat_map(|scene| &scene.rows);
    let agreements = rows.filter_map(|row| row.measured_figures()?.agreement);
    let (masks, off) = agreements.fold((0, 0), |(masks, off), agreement| {
        (masks + 1, off + agreement.violations)
    });
    out.masks = Some(masks);
    out.decided_pixels_off = (masks > 0).then_some(off);
    out.findings = comparison.faults();
    Ok(out)
}
