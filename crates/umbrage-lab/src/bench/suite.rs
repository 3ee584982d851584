//! Benchmarks: the CPU backend against wgpu, rays against obvhs, and wgpu against a hand-written
//! program.

use super::{
    handwritten::{FrameSettings, HandWritten},
    paired::{Pair, Paired, Repetitions, measure_pairs},
    rays,
};
use crate::error::LabError;
use std::time::Duration;
use umbrage_core::{
    Backend, BackendError, Camera, Geometry, Light, Receivers, Recipe, Scene, ShadowTechnique,
    View,
    glam::{UVec2, Vec3},
};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_scenes::Kind;
use umbrage_techniques::{Bias, Hard, MapFilter as _, Pcf, Pcss, ShadowMap};
use umbrage_wgpu::{Gpu, wgpu::DeviceType};

/// Options of the benchmarks.
#[derive(Clone, Copy, Debug)]
pub struct BenchOptions {
    /// Counted pairs.
    pub runs: usize,
    /// Uncounted pairs before them.
    pub warm_up: usize,
    /// CPU threads of our side. Software adapters use all cores in any case.
    pub threads: usize,
}

impl Default for BenchOptions {
    fn default() -> Self {
        Self {
            runs: 20,
            warm_up: 3,
            threads: 2,
        }
    }
}

/// Image size of lookups, pixels.
const SCREEN: UVec2 = UVec2::new(1280, 720);
/// Side of the maps, texels.
const MAP: u32 = 2048;
/// Image size for the origins of rays, pixels.
const RAY_SCREEN: UVec2 = UVec2::new(640, 360);

/// A scene of the speed benchmarks.
struct SpeedScene {
    name: &'static str,
    geometry: Geometry,
    camera: Camera,
    light: Light,
    receivers: Receivers,
}

impl SpeedScene {
    fn new(
        name: &'static str,
        scene: &Scene,
        size: UVec2,
        cpu: &mut Cpu,
    ) -> Result<Self, LabError> {
        let geometry = Geometry::bake(scene)?;
        let camera = scene.cameras[0].with_size(size);
        let receivers = cpu.receivers(&camera, &geometry)?;
        Ok(Self {
            name,
            geometry,
            camera,
            light: scene.lights[0],
            receivers,
        })
    }

    /// Returns the scene under a light with an extent: the sun's angular diameter, or a radius of
    /// 0.1 m.
    fn with_extent(&self) -> Self {
        let mut light = self.light;
        match &mut light {
            Light::Directional {
                angular_diameter: extent,
                ..
            } => *extent = 0.0093,
            Light::Spot { radius: extent, .. } | Light::Point { radius: extent, .. } => {
                *extent = 0.1
            }
            Light::Rect { .. } | Light::Disc { .. } => {}
        }
        Self {
            geometry: self.geometry.clone(),
            receivers: self.receivers.clone(),
            light,
            ..*self
        }
    }

    fn view(&self) -> View<'_> {
        View::new(&self.camera, &self.light, &self.geometry).with_receivers(&self.receivers)
    }
}

/// Runs all benchmarks. Passes each result to `on_pair` when it is complete. Without a graphics
/// adapter only rays are compared.
///
/// # Errors
/// Errors if a backend fails.
pub fn run(
    options: BenchOptions,
    gpu: Option<&mut Gpu>,
    mut on_pair: impl FnMut(Pair),
) -> Result<(), LabError> {
    let mut cpu = Cpu::with_options(&CpuOptions::default().threads(options.threads))?;
    let repetitions = Repetitions {
        warm_up: options.warm_up,
        runs: options.runs,
    };
    // Area lights are made from ideal ones below.
    let entries = umbrage_scenes::all()
        .iter()
        .filter(|entry| entry.kind == Kind::Speed);
    let scenes: Vec<(&str, Scene)> = entries
        .map(|entry| (entry.name, (entry.build)()))
        .filter(|(_, scene)| scene.lights[0].is_ideal())
        .collect();
    // Compare the backends, and wgpu with the hand-written program.
    if let Some(gpu) = gpu {
        for (name, scene) in &scenes {
            let stage = SpeedScene::new(name, scene, SCREEN, &mut cpu)?;
            on_pair(depth(&stage, repetitions, &mut cpu, gpu)?);
        }
        for (name, scene) in &scenes {
            let stage = SpeedScene::new(name, scene, SCREEN, &mut cpu)?;
            for (radius, bar) in [(1, 5.0), (3, 8.0)] {
                on_pair(lookup(&stage, radius, bar, repetitions, &mut cpu, gpu)?);
            }
            on_pair(soft(&stage.with_extent(), repetitions, &mut cpu, gpu)?);
            for pair in by_hand(&stage, repetitions, gpu)? {
                on_pair(pair);
            }
        }
    }
    // Compare rays with obvhs.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build();
    let pool = pool.map_err(|e| LabError::Backend(BackendError::OutOfMemory(e.to_string())))?;
    for (name, scene) in &scenes {
        let stage = SpeedScene::new(name, scene, RAY_SCREEN, &mut cpu)?;
        let pair = pool.install(|| {
            rays::compare(
                name,
                &stage.geometry,
                &stage.receivers,
                &stage.light,
                repetitions,
            )
        });
        on_pair(pair);
    }
    Ok(())
}

fn plan(view: &View<'_>, technique: &dyn ShadowTechnique) -> Result<Recipe, LabError> {
    technique.recipe(view).map_err(LabError::Plan)
}

fn map() -> ShadowMap {
    ShadowMap {
        size: MAP,
        bias: Bias::SLOPE,
        ..ShadowMap::default()
    }
}

/// Selects one of a hand-written frame's times.
type FrameTime = fn(super::handwritten::FrameTimes) -> Duration;

/// Selects one of a rendering's times. `None` if it wasn't timed.
type StageTime = fn(&umbrage_core::Timings) -> Option<Duration>;

/// Returns the target of the CPU backend against a graphics adapter. `None` for hardware, which is
/// not comparable.
fn bar_against(gpu: &Gpu, bar: f64) -> Option<f64> {
    let is_software = gpu.adapter_info().device_type == DeviceType::Cpu;
    is_software.then_some(bar)
}

/// Times one stage of a recipe on both backends.
fn both(
    view: &View<'_>,
    recipe: &Recipe,
    stage: StageTime,
    repetitions: Repetitions,
    cpu: &mut Cpu,
    gpu: &mut Gpu,
) -> Result<Paired, LabError> {
    measure_pairs(
        repetitions,
        || stage_time(cpu, view, recipe, stage),
        || stage_time(gpu, view, recipe, stage),
    )
}

fn stage_time(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
    stage: StageTime,
) -> Result<Duration, LabError> {
    let shadows = backend.render(view, recipe)?;
    stage(&shadows.timings).ok_or_else(|| LabError::NotTimed(backend.name().to_owned()))
}

fn depth(
    stage: &SpeedScene,
    repetitions: Repetitions,
    cpu: &mut Cpu,
    gpu: &mut Gpu,
) -> Result<Pair, LabError> {
    let view = stage.view();
    let recipe = plan(&view, &Hard {}.on(map()))?;
    let paired = both(&view, &recipe, |t| t.cast, repetitions, cpu, gpu)?;
    Ok(Pair {
        work: format!(
            "depth {MAP}x{MAP}, {} ({} triangles)",
            stage.name,
            stage.geometry.casters().len()
        ),
        who: [cpu.name().into(), gpu.name().into()],
        ours: paired.ours,
        theirs: paired.theirs,
        ratio: paired.ratio,
        bar: bar_against(gpu, 6.0),
        runs: repetitions.runs,
        fault: None,
    })
}

fn lookup(
    stage: &SpeedScene,
    radius: u32,
    bar: f64,
    repetitions: Repetitions,
    cpu: &mut Cpu,
    gpu: &mut Gpu,
) -> Result<Pair, LabError> {
    let view = stage.view();
    let recipe = plan(&view, &Pcf::new(radius).on(map()))?;
    let paired = both(&view, &recipe, |t| t.receive, repetitions, cpu, gpu)?;
    let taps = (2 * radius + 1).pow(2);
    Ok(Pair {
        work: format!(
            "PCF of {taps} taps, {}x{}, {}",
            SCREEN.x, SCREEN.y, stage.name
        ),
        who: [cpu.name().into(), gpu.name().into()],
        ours: paired.ours,
        theirs: paired.theirs,
        ratio: paired.ratio,
        bar: bar_against(gpu, bar),
        runs: repetitions.runs,
        fault: None,
    })
}

fn soft(
    stage: &SpeedScene,
    repetitions: Repetitions,
    cpu: &mut Cpu,
    gpu: &mut Gpu,
) -> Result<Pair, LabError> {
    let view = stage.view();
    let technique = Pcss::default().on(ShadowMap {
        size: MAP,
        ..ShadowMap::default()
    });
    let recipe = plan(&view, &technique)?;
    let paired = both(&view, &recipe, lookup_with_filters, repetitions, cpu, gpu)?;
    let blocker_taps = technique.filter.blocker_taps;
    let filter_taps = technique.filter.filter_taps;
    Ok(Pair {
        work: format!(
            "PCSS of {blocker_taps} + {filter_taps} taps, {}x{}, {}",
            SCREEN.x, SCREEN.y, stage.name
        ),
        who: [cpu.name().into(), gpu.name().into()],
        ours: paired.ours,
        theirs: paired.theirs,
        ratio: paired.ratio,
        bar: bar_against(gpu, 6.0),
        runs: repetitions.runs,
        fault: None,
    })
}

/// Returns the time of the lookup and of filters, which compute the grid that bounds PCSS's search.
fn lookup_with_filters(timings: &umbrage_core::Timings) -> Option<Duration> {
    let receive = timings.receive?;
    Some(receive + timings.filter.unwrap_or_default())
}

/// Times the wgpu backend's passes against those of a hand-written program for this technique.
fn by_hand(
    stage: &SpeedScene,
    repetitions: Repetitions,
    gpu: &mut Gpu,
) -> Result<Vec<Pair>, LabError> {
    let view = stage.view();
    let technique = Pcf::new(1).on(map());
    let recipe = plan(&view, &technique)?;
    let (device, queue) = gpu.device();
    let program = HandWritten::new(
        device,
        queue,
        &stage.geometry,
        &stage.receivers,
        &FrameSettings {
            space: recipe.casts[0].space,
            to_light: stage.light.direction_from(Vec3::ZERO),
            map_size: MAP,
            radius: 1,
        },
    );
    let who = [format!("umbrage on {}", gpu.name()), "by hand".to_owned()];
    let passes: [(&str, StageTime, FrameTime); 2] = [
        ("depth", |t| t.cast, |t| t.cast),
        ("PCF of 9 taps", |t| t.receive, |t| t.receive),
    ];
    let mut pairs = Vec::new();
    for (name, ours_time, theirs_time) in passes {
        let ours = || {
            let timings = gpu.render(&view, &recipe)?.timings;
            ours_time(&timings).ok_or_else(|| LabError::NotTimed(gpu.name().to_owned()))
        };
        let theirs = || {
            program
                .frame()
                .map(theirs_time)
                .map_err(|e| LabError::Backend(BackendError::Validation(e)))
        };
        let paired = measure_pairs(repetitions, ours, theirs)?;
        let work = format!("{name} on wgpu, {}", stage.name);
        pairs.push(Pair {
            work,
            who: who.clone(),
            ours: paired.ours,
            theirs: paired.theirs,
            ratio: paired.ratio,
            bar: Some(1.0 / 1.15),
            runs: repetitions.runs,
            fault: None,
        });
    }
    Ok(pairs)
}
