//! Times of light sets: compared with code written by hand, with many casters, and with lists that
//! the device makes.

mod by_hand;
mod by_set;
mod lists;
mod program;

pub use lists::lists;

use crate::{
    renderer::{BoxScene, Boxes, Graphics},
    set::BoxShadows,
};
use anyhow::{Result, ensure};
use by_hand::{ByHand, HandLookup};
use program::{LookupStage, SceneShadows, TimedRenderer};
use std::{
    cell::Cell,
    collections::BTreeMap,
    sync::Arc,
    time::{Duration, Instant},
};
use umbrage::{
    ShadowTechnique,
    gpu::{AdapterChoice, Gpu},
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

/// Returns `hard`, or `pcf` with a radius of 1, with a constant bias.
fn technique(radius: u32) -> Arc<dyn ShadowTechnique> {
    let map = ShadowMap {
        size: MAP_SIZE,
        bias: Bias {
            constant: BIAS,
            ..Bias::NONE
        },
        ..ShadowMap::default()
    };
    if radius == 0 {
        Arc::new(Hard {}.on(map))
    } else {
        Arc::new(Pcf { radius }.on(map))
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
            "{name:17} all casters move {:.3}   nothing moves {:.3}   recording {:.2}   pixels that differ: {}",
            ratios.moving, ratios.still, ratios.recording, ratios.differing
        );
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
    let stages = [
        ("forward", LookupStage::Forward),
        ("deferred", LookupStage::Deferred),
        ("masks", LookupStage::Masks),
    ];
    let mut all = Vec::new();
    for (stage_name, stage) in stages {
        for (name, radius) in [("hard", 0), ("pcf 3x3", 1)] {
            let ratios = ratios_of(graphics, radius, stage)?;
            all.push((format!("{stage_name}, {name}"), ratios));
        }
    }
    Ok(all)
}

fn ratios_of(graphics: &Graphics, radius: u32, stage: LookupStage) -> Result<Ratios> {
    let technique = technique(radius);
    let boxes = || Ok::<_, anyhow::Error>(Boxes::new(graphics, BoxScene::large()?));
    let of_set = boxes()?;
    let mut set = BoxShadows::new(graphics, &of_set)?;
    set.add_lights(&of_set.scene.lights, &technique)?;
    let of_hand = boxes()?;
    let lookup = HandLookup {
        bias: BIAS,
        radius: radius as i32,
        map_size: MAP_SIZE,
    };
    let hand = ByHand::new(graphics, &of_hand, &*technique, &set.set, lookup)?;
    let mut set = TimedRenderer::new(graphics, of_set, set, stage);
    let mut hand = TimedRenderer::new(graphics, of_hand, hand, stage);
    let differing = check_alike(graphics, &mut set, &mut hand)?;

    let frames = Cell::new(0.0);
    // Every frame differs.
    let seconds = || frames.replace(frames.get() + 0.01);
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
    let recording = measure_pairs(
        PAIRS,
        || record_frame(graphics, || hand.frame(graphics, seconds())),
        || record_frame(graphics, || set.frame(graphics, seconds())),
    )?;
    Ok(Ratios {
        moving: moving.ratio,
        still: still.ratio,
        recording: recording.ratio,
        differing,
    })
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

/// Prints the time of preparing 10,000 casters of which 100 move.
///
/// # Errors
/// Returns an error if the device fails.
pub fn casters() -> Result<()> {
    const MOVED: usize = 100;
    const FRAMES: usize = 60;
    let (_, graphics) = open(&AdapterChoice::from_env())?;
    let boxes = Boxes::new(&graphics, BoxScene::crowded_scene()?);
    let mut shadows = BoxShadows::new(&graphics, &boxes)?;
    shadows.add_lights(&boxes.scene.lights, &technique(1))?;
    let count = shadows.casters.len();
    let mut times = Vec::new();
    for frame in 0..FRAMES {
        let start = Instant::now();
        let placements = boxes.scene.placements(0.01 * frame as f32);
        let placing = start.elapsed();
        for i in 0..MOVED {
            let caster = 1 + (97 * i + frame) % (count - 1);
            let place = placements[caster];
            shadows.set.move_caster(shadows.casters[caster], place)?;
        }
        shadows.prepare(&boxes)?;
        times.push(1e3 * (start.elapsed() - placing).as_secs_f64());
        let mut encoder = graphics.encoder();
        shadows.set.encode(&mut encoder)?;
        graphics.queue.submit([encoder.finish()]);
        graphics.wait()?;
    }
    times.sort_by(f64::total_cmp);
    let median = times[FRAMES / 2];
    let report = shadows.set.report();
    println!(
        "{count} casters, {MOVED} of them moved, {} lights: {median:.2} ms to move and prepare (median of {FRAMES} frames), {} layers drawn again, {} bytes written",
        shadows.lights.len(),
        report.redrawn,
        report.uploaded
    );
    Ok(())
}
