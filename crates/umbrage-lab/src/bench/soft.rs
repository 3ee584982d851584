//! Times `soft` against rays with the same error, under the area lights of full-size scenes.

use super::{
    lists::{fits_memory, plan, receive_time},
    paired::{Pair, Paired, Repetitions, measure_pairs},
};
use crate::error::LabError;
use std::cell::RefCell;
use umbrage_core::{
    Backend, Geometry, Light, Receivers, Recipe, View,
    glam::UVec2,
    metrics::{Errors, Pixel},
};
use umbrage_cpu::Cpu;
use umbrage_scenes::{Kind, SceneEntry};
use umbrage_techniques::{Soft, Traced};
use umbrage_wgpu::Gpu;

/// Image size, pixels.
const SCREEN: UVec2 = UVec2::new(1280, 720);
/// Requested errors. A graphics adapter only gets the first, since rays take minutes there.
const ERRORS: [f32; 3] = [0.04, 0.015, 0.006];
/// Rays of truth per judged pixel. Their error is a fifth of the least error above.
const TRUTH_RAYS: u32 = 2048;
/// Side of the squares of which one pixel each is judged.
const PIXEL_STEP: usize = 11;
/// Candidate numbers of rays.
const RAYS: [u32; 22] = [
    1, 2, 3, 4, 6, 8, 11, 14, 18, 23, 29, 36, 45, 56, 70, 88, 110, 140, 180, 240, 320, 480,
];
/// Targets of a lookup on the CPU and on a graphics adapter: how many times faster than rays with
/// the same error.
const CPU_BAR: f64 = 5.0;
const GPU_BAR: f64 = 3.0;

/// Times `soft` in the named content scenes (all of them without names), for each light with an
/// extent.
///
/// Passes each result to `on_pair` when it is complete. Without a graphics adapter only the CPU is
/// timed.
///
/// # Errors
/// Errors if a scene is invalid or a backend fails.
pub fn soft(
    runs: usize,
    scenes: &[String],
    mut gpu: Option<&mut Gpu>,
    mut on_pair: impl FnMut(Pair),
) -> Result<(), LabError> {
    let repetitions = Repetitions { warm_up: 0, runs };
    let wanted = |entry: &&SceneEntry| {
        let is_named = scenes.iter().any(|name| name == entry.name);
        is_named || (scenes.is_empty() && entry.kind == Kind::Content)
    };
    for entry in umbrage_scenes::all().iter().filter(wanted) {
        let scene = (entry.build)();
        if scene.lights.iter().all(Light::is_ideal) {
            continue;
        }
        let geometry = Geometry::bake(&scene)?;
        // Skip scenes with alpha-tested casters unless they are named: their alpha tests per point
        // are no cost of shafts.
        if scenes.is_empty() && geometry.has_cut_out_casters() {
            continue;
        }
        let camera = scene.cameras[0].with_size(SCREEN);
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(&camera, &geometry)?;
        for (number, light) in scene.lights.iter().enumerate() {
            if light.is_ideal() {
                continue;
            }
            let mut stage = SoftBench {
                name: format!("{}, {} light {number}", entry.name, light.kind()),
                view: View::new(&camera, light, &geometry).with_receivers(&receivers),
                repetitions,
                pixels: pixels_of(&receivers),
                cpu: Cpu::new(),
            };
            stage.time(gpu.as_deref_mut(), &mut on_pair)?;
        }
    }
    Ok(())
}

/// Returns one receiver pixel of each square.
fn pixels_of(receivers: &Receivers) -> Vec<u32> {
    let width = receivers.size.x as usize;
    let is_looked_at = |i: &usize| {
        let [column, row] = [i % width, i / width];
        let is_first = column.is_multiple_of(PIXEL_STEP) && row.is_multiple_of(PIXEL_STEP);
        receivers.receives[*i] && is_first
    };
    let all = 0..receivers.len();
    all.filter(is_looked_at).map(|i| i as u32).collect()
}

/// One scene and light of the benchmark.
struct SoftBench<'a> {
    name: String,
    view: View<'a>,
    repetitions: Repetitions,
    /// Pixels at which errors are measured.
    pixels: Vec<u32>,
    cpu: Cpu,
}

impl SoftBench<'_> {
    fn time(
        &mut self,
        mut gpu: Option<&mut Gpu>,
        on_pair: &mut impl FnMut(Pair),
    ) -> Result<(), LabError> {
        // Find the number of rays with the same error, and time both.
        let truth = self.answers(&plan(
            &self.view,
            &Traced {
                samples: TRUTH_RAYS,
            },
        )?)?;
        for (number, error) in ERRORS.into_iter().enumerate() {
            let soft = plan(&self.view, &Soft { error })?;
            let found = rmse(&self.answers(&soft)?, &truth)?;
            let Some(rays) = self.rays_with(found, &truth)? else {
                continue;
            };
            let traced = plan(&self.view, &Traced { samples: rays })?;
            let what = format!("error {error}, {}, RMSE {found:.4}", self.name);
            let who = ["soft".to_owned(), format!("{rays} rays")];
            let on_cpu = turns(
                &mut self.cpu,
                &self.view,
                self.repetitions,
                [&soft, &traced],
            )?;
            on_pair(self.pair(&what, &who, on_cpu, CPU_BAR));
            if number == 0
                && let Some(gpu) = gpu.as_deref_mut()
                && fits_memory(gpu.render(&self.view, &traced))?
            {
                let on_gpu = turns(gpu, &self.view, self.repetitions, [&soft, &traced])?;
                on_pair(self.pair(&format!("on wgpu, {what}"), &who, on_gpu, GPU_BAR));
            }
        }
        Ok(())
    }

    /// Returns the visibilities at the judged pixels.
    fn answers(&mut self, recipe: &Recipe) -> Result<Vec<f32>, LabError> {
        let answers = self.cpu.render_pixels(&self.view, recipe, &self.pixels)?;
        Ok(answers)
    }

    /// Returns the least number of rays whose error is at most this. `None` if all candidates
    /// exceed it.
    fn rays_with(&mut self, error: f64, truth: &[f32]) -> Result<Option<u32>, LabError> {
        for samples in RAYS {
            let traced = plan(&self.view, &Traced { samples })?;
            if rmse(&self.answers(&traced)?, truth)? <= error {
                return Ok(Some(samples));
            }
        }
        Ok(None)
    }

    fn pair(&self, work: &str, who: &[String; 2], paired: Paired, bar: f64) -> Pair {
        Pair {
            work: work.to_owned(),
            who: who.clone(),
            ours: paired.ours,
            theirs: paired.theirs,
            ratio: paired.ratio,
            bar: Some(bar),
            runs: self.repetitions.runs,
            fault: None,
        }
    }
}

/// Returns the root mean square error of some visibilities.
fn rmse(answers: &[f32], truth: &[f32]) -> Result<f64, LabError> {
    // Measure them as one row: only errors of neighbours depend on the image's shape, and they
    // aren't used.
    let size = UVec2::new(truth.len() as u32, 1);
    let pixels = vec![Pixel::Counted; truth.len()];
    Ok(Errors::measure(size, answers, truth, &pixels)?.rmse)
}

/// Runs two recipes in turn.
fn turns(
    backend: &mut dyn Backend,
    view: &View<'_>,
    repetitions: Repetitions,
    recipes: [&Recipe; 2],
) -> Result<Paired, LabError> {
    // Upload and compile before timing.
    backend.render(view, recipes[0])?;
    let backend = RefCell::new(backend);
    let time = |recipe: &Recipe| receive_time(&mut **backend.borrow_mut(), view, recipe);
    measure_pairs(repetitions, || time(recipes[0]), || time(recipes[1]))
}
