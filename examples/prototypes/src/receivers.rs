//! Candidate (c): an irregular z-buffer. Receivers are binned over the light's view, and casters
//! walk over them.
//!
//! Johnson and others 2005, "The Irregular Z-Buffer"; Wyman, Hoetzlein and Lefohn 2015,
//! "Frustum-Traced Raster Shadows".

use crate::{
    device::{Device, GROUP},
    frame::Frame,
    outcome::{Made, Outcome},
    sort::Scan,
    tree::rects_wgsl,
};
use anyhow::{Result, ensure};
use std::time::Duration;

/// Cells along the side of a directional light's face, and of a point light's.
const SIDES: [u32; 2] = [1024, 512];
/// Number of workgroups for large casters.
const LARGE_GROUPS: u32 = 4096;
/// Number of receivers of a cell that a pass walks. Mesa's lavapipe ends all loops of an invocation
/// after 65,535 iterations, and a caster may touch 64 cells.
const SLICE: u32 = 512;
const CORNERS: f64 = 48.0;
const MAKE_CORNERS: f64 = 96.0;

/// Runs the candidate.
pub(crate) fn run(device: &Device, frame: &Frame) -> Result<Outcome> {
    let side = SIDES[usize::from(frame.is_lamp)];
    let cell_count = if frame.is_lamp { 6 } else { 1 } * side * side;
    let large_room = frame.casters + 1024;
    let kernel = device.read(&frame.kernel)?;
    let half = frame.kernel_offset("grid")?;
    let place = [
        frame.casters,
        side,
        cell_count,
        large_room,
        frame.size.x,
        frame.size.y,
        kernel[half],
        kernel[half + 1],
    ];
    let ray = frame.ray_wgsl()?;
    let bins_wgsl = format!("{ray}{}", include_str!("../shaders/bins.wgsl"));
    let entries = ["find_bounds", "count_receivers", "bin_receivers"];
    let bins = device.program("bins", &bins_wgsl, &entries, &[]);
    // Both of the library's modules have a function of this name.
    let rects = rects_wgsl(frame)?.replace("frame_point(", "caster_point(");
    let Some((_, rects)) = rects.split_once("// ---- touch.wgsl") else {
        anyhow::bail!("the library's modules have changed");
    };
    let casts_wgsl = format!("{ray}{rects}{}", include_str!("../shaders/casts.wgsl"));
    let scan = Scan::new(device);

    let words = |count: u32| device.zeros("words", 4 * u64::from(count));
    let made_of = |first: u32| {
        let mut words = place.to_vec();
        words.extend([first, SLICE, 0, 0]);
        device.uniform("made", bytemuck::cast_slice(&words))
    };
    let made = made_of(0);
    let grid = device.uniform("grid", bytemuck::cast_slice(&frame.grid));
    let counts = words(cell_count + 1);
    let taken = words(cell_count);
    let deepest = words(cell_count);
    let binned = words(8 * frame.pixels());
    let ends = words(4);
    let answers = words(frame.pixels());
    let counted = words(2 * frame.pixels());
    let large = words(4 + large_room);
    let walks = words(4);
    let named = [
        ("kernel", &frame.kernel),
        ("made", &made),
        ("grid", &grid),
        ("receivers", &frame.receivers),
        ("corners", &frame.corners),
        ("table_3", &frame.corners),
        ("table_4", &frame.cut_outs),
        ("counts", &counts),
        ("taken", &taken),
        ("deepest", &deepest),
        ("binned", &binned),
        ("ends", &ends),
        ("answers", &answers),
        ("counted", &counted),
        ("large", &large),
        ("walks", &walks),
    ];
    let cleared = [
        &counts, &taken, &deepest, &ends, &counted, &large, &walks, &answers,
    ];
    let pixel_groups = frame.pixels().div_ceil(GROUP);
    let caster_groups = frame.casters.div_ceil(GROUP);
    let cell_scan = Scan::buffers(device, cell_count + 1);
    let mut times = Vec::new();
    for does_count in [0.0, 1.0] {
        let constants = [("COUNTS", does_count)];
        let entries = ["cast_small", "cast_large"];
        let casts = device.program("casts", &casts_wgsl, &entries, &constants);
        let mut all = Vec::new();
        all.push(device.dispatch(&bins, "find_bounds", &named, pixel_groups)?);
        all.push(device.dispatch(&bins, "count_receivers", &named, pixel_groups)?);
        scan.record(device, &cell_scan, &counts, &mut all)?;
        all.push(device.dispatch(&bins, "bin_receivers", &named, pixel_groups)?);
        let mut time = device.run(&cleared, &all)?;
        // Walk the longest list in several passes.
        let firsts = device.read(&counts)?;
        let lists = firsts[..=cell_count as usize].windows(2);
        let longest = lists.map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        for first in (0..longest.max(1)).step_by(SLICE as usize) {
            let made = made_of(first);
            let mut sliced = vec![("made", &made)];
            sliced.extend(named);
            let passes = [
                device.dispatch(&casts, "cast_small", &sliced, caster_groups)?,
                device.dispatch(&casts, "cast_large", &sliced, LARGE_GROUPS)?,
            ];
            time += device.run(&[], &passes)?;
        }
        times.push(time);
    }
    let large_count = device.read(&large)?[0];
    ensure!(large_count <= large_room, "{large_count} large casters");
    let walked = device.read(&walks)?;
    let words = device.read(&counted)?;
    let counted: Vec<[u32; 2]> = words.chunks_exact(2).map(|c| [c[0], c[1]]).collect();
    let casters = f64::from(frame.casters.max(1));
    let asking = frame.faces_light.iter().filter(|&&f| f).count().max(1) as f64;
    let made = Made {
        items: 0.0,
        bytes: MAKE_CORNERS + CORNERS,
        atomics: f64::from(large_count) / casters,
        kept: CORNERS,
        scratch: 0.0,
    };
    // Binning reads a receiver three times and writes it once, with four atomics; the scan moves
    // three words a cell. Cells cost three words a visit.
    let binning = 3.0 * 32.0 + 32.0 + 4.0 * 8.0;
    let cells = 12.0 * f64::from(cell_count) / asking + 12.0 * f64::from(walked[0]) / asking;
    Ok(Outcome {
        candidate: "casters walk receivers".to_owned(),
        answers: device.read(&answers)?[..frame.pixels() as usize].to_vec(),
        counted: counted[..frame.pixels() as usize].to_vec(),
        make: Duration::ZERO,
        look_up: times[0],
        made,
        bytes_walked: 16.0,
        bytes_tested: 16.0 + 4.0,
        bytes_more: binning + cells,
        // Here lanes are casters, not receivers.
        caster_walks: Some([f64::from(walked[2]), f64::from(walked[1]) / (asking / 32.0)]),
    })
}
