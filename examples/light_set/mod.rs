//! Times of light sets: compared with code written by hand, with many casters, and with hierarchies
//! that the device builds.

mod by_hand;
mod by_set;
mod lists;
mod program;

pub use lists::lists;

use crate::{
    renderer::{BoxScene, Boxes, Graphics},
    set::BoxShadows,
};
use anyhow::{Context as _, Result, ensure};
use by_hand::{ByHand, HandLookup};
use program::{LookupStage, SceneShadows, TimedRenderer};
use std::{
    cell::Cell,
    collections::BTreeMap,
    sync::Arc,
    time::{Duration, Instant},
};
use umbrage::{
    Cascades, Layout, Light, ShadowTechnique,
    gpu::{
        AdapterChoice, Gpu, LightSet,
        wgpu::{Backends, DeviceDescriptor, Instance, InstanceDescriptor},
    },
    techniques::{Bias, Hard, MapFilter as _, Pcf, ShadowMap},
};
use umbrage_lab::bench::{Repetitions, measure_pairs};

/// Number of frames of each program, alternating. Shaders are compiled in the warm-up frames.
const PAIRS: Repetitions = Repetitions {
    warm_up: 3,
    runs: 24,
};
/// Greatest number of different pixels, of 921,600. The two programs round the edge of a map
/// differently.
const MOST_DIFFERING: usize = 2000;
/// Constant bias of all maps, clip depth.
const BIAS: f32 = 0.002;
/// Side of all maps, texels.
const MAP_SIZE: u32 = 1024;

/// Opens the device of an adapter with all limits of the adapter, since lists of many triangles are
/// long.
fn open(choice: &AdapterChoice) -> Result<(String, Graphics)> {
    let gpu = Gpu::new(choice)?;
    let (device, queue) = gpu.device();
    let graphics = Graphics {
        device: device.clone(),
        queue: queue.clone(),
    };
    Ok((gpu.adapter_info().name, graphics))
}

/// Opens the backend of wgpu that draws nothing: times of the processor don't include a driver. A
/// software driver draws with the same cores and caches.
fn open_without_driver() -> Result<(String, Graphics)> {
    let mut desc = InstanceDescriptor::new_without_display_handle();
    desc.backends = Backends::NOOP;
    desc.backend_options.noop.enable = true;
    let adapters = pollster::block_on(Instance::new(desc).enumerate_adapters(Backends::NOOP));
    let adapter = adapters.first().context("wgpu has no backend `noop`")?;
    let desc = DeviceDescriptor {
        required_limits: LightSet::REQUIRED_LIMITS,
        ..DeviceDescriptor::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&desc))?;
    Ok(("no driver".to_owned(), Graphics { device, queue }))
}

/// Returns `pcf`, or `hard` if there is no filter, with a constant bias and maps of a layout.
fn technique(layout: Layout, filter: Option<Pcf>) -> Arc<dyn ShadowTechnique> {
    let map = ShadowMap {
        size: MAP_SIZE,
        layout,
        bias: Bias {
            constant: BIAS,
            ..Bias::NONE
        },
        ..ShadowMap::default()
    };
    match filter {
        Some(filter) => Arc::new(filter.on(map)),
        None => Arc::new(Hard {}.on(map)),
    }
}

/// Times of the set over times by hand.
struct Ratios {
    moving: f64,
    still: f64,
    recording: f64,
    differing: usize,
}

/// Prints times of the set over times by hand.
///
/// # Errors
/// Returns an error if the device fails, or the two programs draw different images.
pub fn compare() -> Result<()> {
    let (name, graphics) = open(&AdapterChoice::from_env())?;
    let pairs = PAIRS.runs;
    println!("{name}: times of the set over times by hand, median of {pairs} pairs");
    for (name, ratios) in all_ratios(&graphics)? {
        println!(
            "{name:30} all casters move {:.3}   nothing moves {:.3}   recording {:.2}   pixels that differ: {}",
            ratios.moving, ratios.still, ratios.recording, ratios.differing
        );
    }
    let (name, graphics) = open_without_driver()?;
    println!("{name}: recording, if all casters move");
    for (name, stage, filter) in looks() {
        let (mut set, mut hand) = renderers(&graphics, filter, stage)?;
        let ratio = recording_ratio(&graphics, &mut set, &mut hand)?;
        println!("{name:30} {ratio:.2}");
    }
    Ok(())
}

/// Returns ratios of the set's times to those of the program by hand, by what was drawn and whether
/// casters move.
///
/// # Errors
/// Returns an error if the device fails, or the two programs draw different images.
pub fn ratios(choice: &AdapterChoice) -> Result<BTreeMap<String, f64>> {
    let (_, graphics) = open(choice)?;
    let mut out = BTreeMap::new();
    for (name, ratios) in all_ratios(&graphics)? {
        let name = format!("light set over by hand, {name}");
        out.insert(format!("{name}, all casters move"), ratios.moving);
        out.insert(format!("{name}, nothing moves"), ratios.still);
    }
    Ok(out)
}

fn all_ratios(graphics: &Graphics) -> Result<Vec<(String, Ratios)>> {
    let named = |(name, stage, filter)| Ok((name, ratios_of(graphics, filter, stage)?));
    looks().map(named).collect()
}

/// Returns the images to draw: their names, stages and filters.
fn looks() -> impl Iterator<Item = (String, LookupStage, Option<Pcf>)> {
    let stages = [
        ("forward", LookupStage::Forward),
        ("deferred", LookupStage::Deferred),
        ("masks", LookupStage::Masks),
    ];
    stages.into_iter().flat_map(|(stage_name, stage)| {
        let techniques = [
            ("hard", None),
            // The radius is a constant by hand, too.
            ("pcf 3x3", Some(Pcf::unrolled(1))),
            ("pcf 3x3 by a uniform", Some(Pcf::new(1))),
        ];
        techniques.map(|(name, filter)| (format!("{stage_name}, {name}"), stage, filter))
    })
}

/// Returns the set's renderer and the one by hand.
fn renderers(
    graphics: &Graphics,
    filter: Option<Pcf>,
    stage: LookupStage,
) -> Result<(TimedRenderer<BoxShadows>, TimedRenderer<ByHand>)> {
    let technique = technique(Layout::Auto, filter);
    let boxes = || Ok::<_, anyhow::Error>(Boxes::new(graphics, BoxScene::large()?));
    let of_set = boxes()?;
    let mut set = BoxShadows::new(graphics, &of_set)?;
    set.add_lights(&of_set.scene.lights, &technique)?;
    let of_hand = boxes()?;
    let lookup = HandLookup {
        bias: BIAS,
        radius: filter.map_or(0, |filter| filter.radius as i32),
        map_size: MAP_SIZE,
    };
    let hand = ByHand::new(
        graphics,
        &of_hand,
        |_| Arc::clone(&technique),
        &set.set,
        lookup,
    )?;
    Ok((
        TimedRenderer::new(graphics, of_set, set, stage),
        TimedRenderer::new(graphics, of_hand, hand, stage),
    ))
}

fn ratios_of(graphics: &Graphics, filter: Option<Pcf>, stage: LookupStage) -> Result<Ratios> {
    let (mut set, mut hand) = renderers(graphics, filter, stage)?;
    let differing = check_alike(graphics, &mut set, &mut hand)?;
    let seconds = changing_seconds();
    let moving = measure_pairs(
        PAIRS,
        || time_frame(graphics, || hand.frame(graphics, seconds())),
        || time_frame(graphics, || set.frame(graphics, seconds())),
    )?;
    let still = measure_pairs(
        PAIRS,
        || time_frame(graphics, || hand.still_frame(graphics)),
        || time_frame(graphics, || set.still_frame(graphics)),
    )?;
    Ok(Ratios {
        moving: moving.ratio,
        still: still.ratio,
        recording: recording_ratio(graphics, &mut set, &mut hand)?,
        differing,
    })
}

/// Returns the set's time of moving, preparing and recording over that by hand.
fn recording_ratio(
    graphics: &Graphics,
    set: &mut TimedRenderer<BoxShadows>,
    hand: &mut TimedRenderer<ByHand>,
) -> Result<f64> {
    let seconds = changing_seconds();
    let recording = measure_pairs(
        PAIRS,
        || record_frame(graphics, || hand.frame(graphics, seconds())),
        || record_frame(graphics, || set.frame(graphics, seconds())),
    )?;
    Ok(recording.ratio)
}

/// Returns a clock in which every frame differs.
fn changing_seconds() -> impl Fn() -> f32 {
    let frames = Cell::new(0.0);
    move || frames.replace(frames.get() + 0.01)
}

/// Returns the time of a frame until its commands are done.
fn time_frame(graphics: &Graphics, frame: impl FnOnce() -> Result<()>) -> Result<Duration> {
    let start = Instant::now();
    frame()?;
    graphics.wait()?;
    Ok(start.elapsed())
}

/// Returns the time of a frame until its commands are submitted.
fn record_frame(graphics: &Graphics, frame: impl FnOnce() -> Result<()>) -> Result<Duration> {
    let start = Instant::now();
    frame()?;
    let recording = start.elapsed();
    graphics.wait()?;
    Ok(recording)
}

/// Returns the number of different pixels. Returns an error if there are many, since the times are
/// then of different work.
fn check_alike(
    graphics: &Graphics,
    set: &mut TimedRenderer<impl SceneShadows>,
    hand: &mut TimedRenderer<impl SceneShadows>,
) -> Result<usize> {
    set.frame(graphics, 0.0)?;
    hand.frame(graphics, 0.0)?;
    let a = graphics.read(graphics.encoder(), &set.color)?;
    let b = graphics.read(graphics.encoder(), &hand.color)?;
    let pairs = a.chunks_exact(4).zip(b.chunks_exact(4));
    let differing = pairs
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 2))
        .count();
    ensure!(
        differing <= MOST_DIFFERING,
        "the two programs draw different images: {differing} pixels"
    );
    Ok(differing)
}

/// Prints how long the processor prepares and records the maps of a frame, in a small and in a
/// crowded scene. The small one is compared with passes recorded by hand.
///
/// # Errors
/// Returns an error if the device fails.
pub fn casters() -> Result<()> {
    let adapter = || open(&AdapterChoice::from_env());
    for open in [&open_without_driver as &dyn Fn() -> Result<_>, &adapter] {
        let (name, graphics) = open()?;
        println!("{name}: median times of the processor for the maps of a frame");
        print_caster_times(&graphics, BoxScene::corner()?, 10)?;
        print_caster_times(&graphics, BoxScene::crowded_scene()?, 100)?;
    }
    Ok(())
}

/// Returns 3x3 comparisons: four cascades for a sun, a single map or a cube for other lights.
fn light_technique(light: &Light) -> Arc<dyn ShadowTechnique> {
    let layout = match light {
        Light::Directional { .. } => Layout::Cascades(Cascades::default()),
        _ => Layout::Auto,
    };
    technique(layout, Some(Pcf::new(1)))
}

/// Prints the median times of frames in which some casters move.
fn print_caster_times(graphics: &Graphics, scene: BoxScene, moved: usize) -> Result<()> {
    const FRAMES: usize = 200;
    let boxes = Boxes::new(graphics, scene);
    let mut shadows = BoxShadows::new(graphics, &boxes)?;
    for light in &boxes.scene.lights {
        shadows.add_lights(&[*light], &light_technique(light))?;
    }
    let lookup = HandLookup {
        bias: BIAS,
        radius: 1,
        map_size: MAP_SIZE,
    };
    let mut hand = ByHand::new(graphics, &boxes, light_technique, &shadows.set, lookup)?;
    let count = shadows.casters.len();
    let mut times: [Vec<f64>; 4] = Default::default();
    for frame in 0..FRAMES {
        let placements = boxes.scene.placements(0.01 * frame as f32);
        let mut start = Instant::now();
        let mut lap = || {
            let microseconds = 1e6 * start.elapsed().as_secs_f64();
            start = Instant::now();
            microseconds
        };
        for i in 0..moved {
            let caster = 1 + (97 * i + frame) % (count - 1);
            shadows
                .set
                .move_caster(shadows.casters[caster], placements[caster])?;
        }
        times[0].push(lap());
        shadows.prepare(&boxes)?;
        times[1].push(lap());
        let mut encoder = graphics.encoder();
        lap();
        shadows.set.encode(&mut encoder)?;
        times[2].push(lap());
        graphics.queue.submit([encoder.finish()]);
        graphics.wait()?;
        let mut encoder = graphics.encoder();
        lap();
        hand.encode(graphics, &boxes, &mut encoder)?;
        times[3].push(lap());
        graphics.queue.submit([encoder.finish()]);
        graphics.wait()?;
    }
    let [place, prepare, encode, by_hand] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[FRAMES / 2]
    });
    let report = shadows.set.report();
    println!(
        "{count} casters, {moved} moved, {} lights: move {place:.1} us, prepare {prepare:.1} us, encode {encode:.1} us in {} passes, {} bytes written; by hand {by_hand:.1} us for all {} layers",
        shadows.lights.len(),
        report.redrawn,
        report.uploaded,
        hand.layers()
    );
    Ok(())
}
