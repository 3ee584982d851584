//! What frames take, beside a program that was written by hand, and what preparing many casters takes.

use super::{
    by_hand::{ByHand, Kernel},
    deferred::{GBuffer, Picture},
    scene::{self, Device, LIGHTS, Stage, lights, read},
};
use anyhow::{Result, ensure};
use std::{
    collections::BTreeMap,
    sync::Arc,
    time::{Duration, Instant},
};
use umbrage::{
    Aabb, ShadowTechnique,
    glam::{Affine3A, Vec3},
    wgpu::{
        AdapterChoice, CasterMesh, LightSet, LightSetOptions, SetFrame, SetLight, VertexLayout,
        wgpu,
    },
};

/// Frames of each program, in turn.
const PAIRS: usize = 24;
/// Frames of each program before any is timed: shaders are compiled in them.
const WARM_UP: usize = 3;
/// Most pixels that may differ, of 921,600: where the two round a map's edge otherwise.
const MOST_DIFFERING: usize = 2000;

/// Prints the median of the quotients of times of the set and of a program by hand, played in turn.
pub fn frames() -> Result<()> {
    let d = Device::open(&AdapterChoice::from_env())?;
    println!(
        "{}: times of the set over times by hand, median of {PAIRS} pairs",
        d.name
    );
    for (name, quotients) in all_quotients(&d)? {
        println!("{name:17} {quotients}");
    }
    Ok(())
}

/// Returns times of the set over times by hand on an adapter, by what was drawn and whether casters move.
///
/// # Errors
/// Errors if the device fails, or the two programs draw different pictures.
pub fn ratios(choice: &AdapterChoice) -> Result<BTreeMap<String, f64>> {
    let d = Device::open(choice)?;
    let mut ratios = BTreeMap::new();
    for (name, quotients) in all_quotients(&d)? {
        ratios.insert(
            format!("light set over by hand, {name}, all casters move"),
            quotients.moving,
        );
        ratios.insert(
            format!("light set over by hand, {name}, nothing moves"),
            quotients.still,
        );
    }
    Ok(ratios)
}

/// Times the set against the program by hand for each kind of picture and kernel.
fn all_quotients(d: &Device) -> Result<Vec<(String, Quotients)>> {
    let gbuffer = GBuffer::new(d)?;
    let pictures = [
        ("forward", Picture::Forward),
        ("deferred", Picture::Deferred(&gbuffer)),
        ("masks", Picture::Masks(&gbuffer)),
    ];
    let mut all = Vec::new();
    let kernels = [("hard", scene::hard(), 0), ("pcf 3x3", scene::pcf(), 1)];
    for (picture_name, picture) in pictures {
        for (name, technique, radius) in &kernels {
            let kernel = Kernel {
                bias: 0.002,
                radius: *radius,
            };
            let quotients = quotients(d, technique, kernel, picture)?;
            all.push((format!("{picture_name}, {name}"), quotients));
        }
    }
    Ok(all)
}

/// Medians of the set's times over times by hand.
struct Quotients {
    moving: f64,
    still: f64,
    recording: f64,
    differing: usize,
}

impl std::fmt::Display for Quotients {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "all casters move {:.3}   nothing moves {:.3}   recording {:.2}   pixels that differ: {}",
            self.moving, self.still, self.recording, self.differing
        )
    }
}

/// Plays both programs in turn.
fn quotients(
    d: &Device,
    technique: &Arc<dyn ShadowTechnique>,
    kernel: Kernel,
    picture: Picture<'_>,
) -> Result<Quotients> {
    let mut set = Stage::new(d, technique.clone())?;
    let casters = set.set.casters_box();
    let mut hand = ByHand::new(d, &**technique, casters, kernel, picture)?;
    let differing = check_alike(d, &mut set, &mut hand, picture)?;
    let mut moving = Vec::new();
    let mut still = Vec::new();
    let mut recorded = Vec::new();
    for i in 0..WARM_UP + PAIRS {
        let time = i as f32 * 0.01;
        let set_moving = timed(d, || set.frame(d, time, picture))?;
        let hand_moving = timed(d, || {
            hand.frame(d, time, picture);
            Ok(())
        })?;
        // By now nothing waits to be drawn again.
        let set_still = timed(d, || set.still_frame(d, picture))?;
        let hand_still = timed(d, || {
            hand.still_frame(d, picture);
            Ok(())
        })?;
        if i >= WARM_UP {
            moving.push(set_moving.all.as_secs_f64() / hand_moving.all.as_secs_f64());
            still.push(set_still.all.as_secs_f64() / hand_still.all.as_secs_f64());
            let recordings = (set_moving.recording, hand_moving.recording);
            recorded.push(recordings.0.as_secs_f64() / recordings.1.as_secs_f64());
        }
    }
    Ok(Quotients {
        moving: median(&mut moving),
        still: median(&mut still),
        recording: median(&mut recorded),
        differing,
    })
}

struct FrameTime {
    /// Until the commands are submitted.
    recording: Duration,
    /// Until they are done.
    all: Duration,
}

fn timed(d: &Device, frame: impl FnOnce() -> Result<()>) -> Result<FrameTime> {
    let start = Instant::now();
    frame()?;
    let recording = start.elapsed();
    d.wait()?;
    Ok(FrameTime {
        recording,
        all: start.elapsed(),
    })
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Returns how many pixels differ. Errors if many do: then their times are of different work.
fn check_alike(
    d: &Device,
    set: &mut Stage,
    hand: &mut ByHand,
    picture: Picture<'_>,
) -> Result<usize> {
    set.frame(d, 0.0, picture)?;
    hand.frame(d, 0.0, picture);
    let a = set.read(d)?;
    let b = read(d, &hand.shared.color)?;
    let pairs = a.chunks_exact(4).zip(b.chunks_exact(4));
    let differing = pairs
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 2))
        .count();
    ensure!(
        differing <= MOST_DIFFERING,
        "the two programs draw different pictures: {differing} pixels"
    );
    Ok(differing)
}

/// Prints what preparing takes with 10,000 casters of which 100 move.
pub fn casters() -> Result<()> {
    const CASTERS: usize = 10_000;
    const MOVED: usize = 100;
    const FRAMES: usize = 60;
    let d = Device::open(&AdapterChoice::from_env())?;
    let camera = scene::camera()?;
    let mut set = LightSet::new(&d.device, LightSetOptions::default())?;
    let vertices = scene::box_vertices();
    let buffer = d.buffer(wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&vertices));
    let mesh = set.add_mesh(&CasterMesh {
        label: "box",
        vertices: &buffer,
        layout: VertexLayout {
            stride: 24,
            ..VertexLayout::PACKED
        },
        indices: None,
        range: 0..vertices.len() as u32,
        base_vertex: 0,
        bounds: Aabb {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        },
    })?;
    let at = |i: usize, y: f32| {
        let x = (i % 100) as f32 * 0.4 - 20.0;
        let z = (i / 100) as f32 * 0.4 - 20.0;
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.1),
            umbrage::glam::Quat::IDENTITY,
            Vec3::new(x, y, z),
        )
    };
    let mut ids = Vec::new();
    for i in 0..CASTERS {
        ids.push(set.add_caster(mesh, at(i, 1.0))?);
    }
    for light in lights() {
        set.add_light(SetLight {
            light,
            technique: scene::pcf(),
            priority: 1.0,
        })?;
    }
    let frame = SetFrame {
        camera: &camera,
        geometry: None,
    };
    let mut times = Vec::new();
    for n in 0..FRAMES {
        let moves = Instant::now();
        for k in 0..MOVED {
            let i = (k * 97 + n) % CASTERS;
            set.move_caster(ids[i], at(i, 1.0 + 0.01 * (n % 7) as f32))?;
        }
        set.prepare(&d.device, &d.queue, &frame)?;
        times.push(moves.elapsed().as_secs_f64() * 1e3);
        let mut encoder = d
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        set.encode(&mut encoder)?;
        d.queue.submit([encoder.finish()]);
        d.wait()?;
    }
    let report = *set.report();
    println!(
        "{CASTERS} casters, {MOVED} of them moved, {LIGHTS} lights: {:.2} ms to move and prepare (median of {FRAMES} frames), {} layers drawn again, {} bytes written",
        median(&mut times),
        report.redrawn,
        report.uploaded
    );
    Ok(())
}
