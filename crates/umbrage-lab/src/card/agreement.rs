//! Whether an adapter's masks are the CPU's.

use super::CardAgreement;
use crate::{
    LabError,
    compare::{Backends, CompareOptions, SceneInput, compare},
};
use glam::UVec2;
use umbrage_core::{Backend, Geometry, Recipe, Scene, ShadowTechnique, Shadows, View};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::TruthOptions;
use umbrage_techniques::{Exact, Soft, Traced, Unshadowed};

/// Built-in scenes of every kind of light: ideal, wide, far from the origin, along surfaces, with casters that have holes.
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

/// Width of the images whose bits are compared, pixels.
const WIDTH: u32 = 240;

/// Returns the techniques without a rasteriser in their answer: functions of the receivers alone, with the same bits on every device that
/// rounds sums and products to nearest.
pub fn exact_techniques() -> [Box<dyn ShadowTechnique>; 4] {
    [
        Box::new(Unshadowed::default()),
        Box::new(Traced { samples: 8 }),
        Box::new(Exact::default()),
        Box::new(Soft::default()),
    ]
}

/// Pixels of a mask, by what two backends make of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BitCounts {
    /// Both see the same triangle.
    pub same_triangle: u64,
    /// They see different ones.
    pub other_triangle: u64,
    /// Of the same triangle, those whose masks have other bits.
    pub other_bits: u64,
}

impl BitCounts {
    /// Counts the pixels of two renderings of one view. Both have receivers of their own.
    pub fn of(mine: &Shadows, theirs: &Shadows) -> Self {
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

/// What two backends rendered of one recipe.
#[derive(Debug)]
pub struct BitPair<'a> {
    /// The scene's name.
    pub scene: &'a str,
    /// The technique's name.
    pub technique: &'a str,
    /// What is seen.
    pub view: View<'a>,
    /// What was rendered.
    pub recipe: &'a Recipe,
    /// What the CPU rendered.
    pub of_cpu: Shadows,
    /// What the other backend rendered.
    pub of_device: Shadows,
}

/// Renders [`BIT_SCENES`] by [`exact_techniques`] on the CPU and on a backend, and passes each pair to `on_pair`.
///
/// # Errors
/// Errors if a backend fails.
pub fn compare_bits(
    backend: &mut dyn Backend,
    on_pair: &mut dyn FnMut(BitPair<'_>),
) -> Result<(), LabError> {
    for name in BIT_SCENES {
        let Some(scene) = small_scene(name) else {
            continue;
        };
        let geometry = Geometry::bake(&scene)?;
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for technique in exact_techniques() {
            // Ideal lights have no soft shadows, and wide ones no exact.
            let Ok(recipe) = technique.recipe(&view) else {
                continue;
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

/// Returns a built-in scene with a camera of [`WIDTH`] pixels.
fn small_scene(name: &str) -> Option<Scene> {
    let mut scene = (umbrage_scenes::find(name)?.build)();
    let camera = scene.cameras.first_mut()?;
    let height = (WIDTH * camera.size.y / camera.size.x).max(1);
    *camera = camera.resized(UVec2::new(WIDTH, height));
    Some(scene)
}

/// Compares an adapter's masks with the CPU's: bits of exact techniques, and decided pixels of all. `backends` are the CPU and the adapter.
///
/// # Errors
/// Errors if a backend fails.
pub fn measure_agreement(backends: &mut Backends) -> Result<CardAgreement, LabError> {
    let mut out = CardAgreement::default();
    for technique in exact_techniques() {
        out.differing_bits.insert(technique.name().to_owned(), 0);
    }
    let mut total = BitCounts::default();
    if let Some(device) = backends.playing.iter_mut().find(|b| b.kind() != "cpu") {
        compare_bits(&mut **device, &mut |pair| {
            let counts = BitCounts::of(&pair.of_cpu, &pair.of_device);
            total.same_triangle += counts.same_triangle;
            total.other_triangle += counts.other_triangle;
            *out.differing_bits
                .entry(pair.technique.to_owned())
                .or_default() += counts.other_bits;
        })?;
    }
    out.same_triangle_pixels = Some(total.same_triangle);
    out.other_triangle_pixels = Some(total.other_triangle);
    let inputs: Vec<SceneInput> = BIT_SCENES
        .iter()
        .filter_map(|name| umbrage_scenes::find(name))
        .map(|entry| SceneInput {
            fit: entry.fit,
            ..SceneInput::new((entry.build)(), "")
        })
        .collect();
    let options = CompareOptions {
        // Errors are not reported, agreement is.
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
    let agreements = rows.filter_map(|row| row.measured()?.agreement);
    let (masks, off) = agreements.fold((0, 0), |(masks, off), agreement| {
        (masks + 1, off + agreement.violations)
    });
    out.masks = Some(masks);
    out.decided_pixels_off = Some(off);
    out.findings = comparison.faults();
    Ok(out)
}
