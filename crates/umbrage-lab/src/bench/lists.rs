//! Times `exact` against a hard map of 2048 texels and single rays, with per-cell triangle lists
//! that are kept, and with everything rebuilt.

use super::paired::{Pair, Paired, Repetitions, measure_pairs};
use crate::error::LabError;
use std::{
    cell::RefCell,
    time::{Duration, Instant},
};
use umbrage_core::{
    Backend, BackendError, Bvh, Geometry, Light, Recipe, ShadowTechnique, View,
    glam::{UVec2, Vec3},
};
use umbrage_cpu::Cpu;
use umbrage_scenes::SceneEntry;
use umbrage_techniques::{Exact, Hard, MapFilter as _, MapTechnique, ShadowMap, Traced};
use umbrage_wgpu::Gpu;

/// Image size, pixels.
const SCREEN: UVec2 = UVec2::new(1280, 720);
/// Side of the map, texels.
const MAP: u32 = 2048;
/// Target of a lookup on the CPU: how many times faster than one ray per receiver.
const RAYS_BAR: f64 = 6.0;
/// Target of a lookup on a graphics adapter.
const GPU_RAYS_BAR: f64 = 8.0;
/// Target relative to a map's lookup on a graphics adapter, in scenes of up to [`SMALL`] triangles.
const GPU_MAP_BAR: f64 = 1.0 / 1.5;
/// A light whose lists are built beforehand, so that preparation per scene is not timed.
const OTHER_LIGHT: Light = Light::Point {
    position: Vec3::ZERO,
    radius: 0.0,
};
/// Maximum number of casters of a small scene.
const SMALL: usize = 300_000;

/// Times lists in the named speed and content scenes (all of them without names), for each ideal
/// light.
///
/// Passes each result to `on_pair` when it is complete. Without a graphics adapter only the CPU is
/// timed.
///
/// # Errors
/// Errors if a scene is invalid or a backend fails.
pub fn lists(
    runs: usize,
    scenes: &[String],
    mut gpu: Option<&mut Gpu>,
    mut on_pair: impl FnMut(Pair),
) -> Result<(), LabError> {
    let repetitions = Repetitions { warm_up: 1, runs };
    let mut cpu = Cpu::new();
    let wanted = |entry: &&SceneEntry| {
        let is_named = scenes.iter().any(|name| name == entry.name);
        let is_large = entry.kind.is_full_size();
        is_named || (scenes.is_empty() && is_large)
    };
    for entry in umbrage_scenes::all().iter().filter(wanted) {
        let scene = (entry.build)();
        if !scene.lights.iter().any(Light::is_ideal) {
            continue;
        }
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].with_size(SCREEN);
        let receivers = cpu.receivers(&camera, &geometry)?;
        for (number, light) in scene.lights.iter().enumerate() {
            if !light.is_ideal() {
                continue;
            }
            let stage = ListsBench {
                name: format!("{}, {} light {number}", entry.name, light.kind()),
                view: View::new(&camera, light, &geometry).with_receivers(&receivers),
                geometry: &geometry,
                repetitions,
            };
            for pair in stage.on_cpu(&mut cpu)? {
                on_pair(pair);
            }
            if let Some(gpu) = gpu.as_deref_mut() {
                for pair in stage.on_gpu(gpu, &mut cpu)? {
                    on_pair(pair);
                }
            }
        }
    }
    Ok(())
}

/// One scene and light of the benchmark.
struct ListsBench<'a> {
    name: String,
    view: View<'a>,
    geometry: &'a Geometry,
    repetitions: Repetitions,
}

impl ListsBench<'_> {
    fn on_cpu(&self, cpu: &mut Cpu) -> Result<Vec<Pair>, LabError> {
        let view = &self.view;
        let exact = plan(view, &Exact::default())?;
        let rays = plan(view, &Traced { samples: 1 })?;
        // Check the results against rays.
        let hard = plan(view, &map())?;
        let expected = cpu.render(view, &rays)?.mask;
        let without_lists = cpu.render(view, &exact)?.mask;
        exact.make_tables();
        let with_lists = cpu.render(view, &exact)?.mask;
        let fault_of_lists = wrong_answers(&expected, &with_lists);
        let fault_without_lists = wrong_answers(&expected, &without_lists);
        // Time the lookup, and everything rebuilt.
        let cpu = RefCell::new(cpu);
        let time = |recipe: &Recipe| receive_time(&mut **cpu.borrow_mut(), view, recipe);
        let rebuild = || self.time_exact_rebuild(&mut cpu.borrow_mut());
        let lookup = measure_pairs(self.repetitions, || time(&exact), || time(&rays))?;
        let against_map = measure_pairs(self.repetitions, rebuild, || {
            Ok(cpu.borrow_mut().render(view, &hard)?.timings.total())
        })?;
        let with_hierarchy = measure_pairs(
            Repetitions {
                warm_up: 0,
                runs: self.repetitions.runs.min(3),
            },
            rebuild,
            || {
                let start = Instant::now();
                drop(Bvh::build(self.geometry));
                let built = start.elapsed();
                Ok::<_, LabError>(built + time(&rays)?)
            },
        )?;
        let mut pairs = vec![
            self.pair("lookup", ["lists", "rays"], lookup, Some(RAYS_BAR)),
            self.pair(
                "rebuilt",
                ["exact", "hard 2048, without its plan"],
                against_map,
                Some(1.0),
            ),
            self.pair(
                "rebuilt",
                ["exact", "hierarchy and rays"],
                with_hierarchy,
                Some(RAYS_BAR),
            ),
        ];
        pairs[0].fault = fault_of_lists;
        pairs[1].fault = fault_without_lists;
        Ok(pairs)
    }

    fn on_gpu(&self, gpu: &mut Gpu, cpu: &mut Cpu) -> Result<Vec<Pair>, LabError> {
        let view = &self.view;
        let exact = plan(view, &Exact::default())?;
        let rays = plan(view, &Traced { samples: 1 })?;
        let hard = plan(view, &map())?;
        // Use the CPU's rays as reference: the hierarchy may exceed the adapter's capacity.
        let expected = cpu.render(view, &rays)?.mask;
        let fault = wrong_answers(&expected, &gpu.render(view, &exact)?.mask);
        let has_rays = fits_memory(gpu.render(view, &rays))?;
        let gpu = RefCell::new(gpu);
        let time = |recipe: &Recipe| receive_time(&mut **gpu.borrow_mut(), view, recipe);
        let mut out = Vec::new();
        if has_rays {
            let paired = measure_pairs(self.repetitions, || time(&exact), || time(&rays))?;
            let who = ["lists", "rays"];
            out.push(self.pair("lookup on wgpu", who, paired, Some(GPU_RAYS_BAR)));
        }
        let against_map = measure_pairs(self.repetitions, || time(&exact), || time(&hard))?;
        let is_small = self.geometry.casters().len() <= SMALL;
        let bar = is_small.then_some(GPU_MAP_BAR);
        let who = ["lists", "hard 2048"];
        out.push(self.pair("lookup on wgpu", who, against_map, bar));
        out[0].fault = fault;
        Ok(out)
    }

    /// Times the first planning and lookup for all receivers. The CPU builds no lists for it.
    fn time_exact_rebuild(&self, cpu: &mut Cpu) -> Result<Duration, LabError> {
        let fresh = self.geometry.without_hierarchies();
        // Prepare the scene once: its boxes, and the extent of receivers.
        let warm = View::new(self.view.camera, &OTHER_LIGHT, &fresh);
        drop(plan(&warm, &Exact::default())?);
        let view = View {
            geometry: Some(&fresh),
            ..self.view
        };
        let start = Instant::now();
        let recipe = plan(&view, &Exact::default())?;
        let made = start.elapsed();
        Ok(made + receive_time(cpu, &view, &recipe)?)
    }

    fn pair(&self, what: &str, who: [&str; 2], paired: Paired, bar: Option<f64>) -> Pair {
        Pair {
            work: format!(
                "{what}, {} ({} casters)",
                self.name,
                self.geometry.casters().len()
            ),
            who: who.map(str::to_owned),
            ours: paired.ours,
            theirs: paired.theirs,
            ratio: paired.ratio,
            bar,
            runs: self.repetitions.runs,
            fault: None,
        }
    }
}

/// Returns what is wrong with the lists' results. `None` if they equal those of rays.
fn wrong_answers(of_rays: &[f32], of_lists: &[f32]) -> Option<String> {
    let pairs = of_rays.iter().zip(of_lists);
    let differ = pairs.filter(|(a, b)| a != b).count();
    let count = of_rays.len();
    (differ > 0).then(|| format!("{differ} of {count} results differ from those of rays"))
}

fn map() -> MapTechnique<Hard> {
    Hard {}.on(ShadowMap {
        size: MAP,
        ..ShadowMap::default()
    })
}

pub(super) fn plan(view: &View<'_>, technique: &dyn ShadowTechnique) -> Result<Recipe, LabError> {
    technique.recipe(view).map_err(LabError::Plan)
}

pub(super) fn receive_time(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
) -> Result<Duration, LabError> {
    let shadows = backend.render(view, recipe)?;
    let receive = shadows.timings.receive;
    receive.ok_or_else(|| LabError::NotTimed(backend.name().to_owned()))
}

/// Reports whether a recipe fits into an adapter's memory.
pub(super) fn fits_memory<T>(rendered: Result<T, BackendError>) -> Result<bool, LabError> {
    match rendered {
        Ok(_) => Ok(true),
        Err(BackendError::Invalid(_)) => Ok(false),
        Err(e) => Err(e.into()),
    }
}
