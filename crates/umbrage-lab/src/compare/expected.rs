//! Counts the work of a comparison and estimates its duration before it begins.

use super::{
    backends::Backends,
    compare,
    event::CompareEvent,
    options::{CompareOptions, SceneInput},
    settings::settings_of,
};
use crate::error::LabError;
use glam::UVec2;
use std::{
    sync::Mutex,
    time::{Duration, Instant},
};
use umbrage_plan::truth::{PREVIEW_SAMPLES, PROBES};

/// Bytes per pixel while rows are rendered, without masks: receivers (eight floats, an id, a flag)
/// of truth and of the backend, truth's results, and camera-sized images of techniques and
/// adapters.
const BYTES_A_PIXEL: u64 = 37 + 37 + 14 + 112;
/// Bytes per pixel of a mask. Each row keeps one mask.
const BYTES_A_MASK: u64 = 4;

/// Maximum pixels of the pilot's smaller image.
const SMALL_PILOT: u64 = 64 * 48;
/// Maximum pixels of the pilot's larger image. The difference of both times removes the part that
/// doesn't depend on the size.
const LARGE_PILOT: u64 = 128 * 96;

/// The counted work of a comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expected {
    /// Scenes.
    pub scenes: usize,
    /// Rows of all scenes together.
    pub rows: usize,
    /// Pixels of all scenes' images together.
    pub pixels: u64,
    /// Maximum number of rays traced for truth.
    pub rays: u64,
    /// Approximate memory, bytes: that of the largest scene.
    pub bytes: u64,
}

impl Expected {
    /// Counts the work of comparing these scenes on this number of backends.
    ///
    /// # Errors
    /// Errors if a scene has no camera or light, or the options are invalid.
    pub fn new(
        inputs: &[SceneInput],
        options: &CompareOptions,
        backends: usize,
    ) -> Result<Self, LabError> {
        let mut out = Self {
            scenes: inputs.len(),
            ..Self::default()
        };
        for input in inputs {
            let (camera, light) = input.camera_and_light()?;
            let rows = settings_of(input, options)?.len() * backends;
            let options = input.options_or(options);
            let pixels = pixels(options.camera(camera).size);
            let truth = &options.truth;
            let mut max_samples = 1;
            let mut probe_samples = 1;
            if !light.is_ideal() {
                max_samples = u64::from(truth.samples) * u64::from(truth.penumbra_factor);
                probe_samples = u64::from(truth.probe_samples);
            }
            let rays_a_pixel = max_samples + PROBES as u64 * probe_samples;
            // One pixel of each block is judged; all pixels get a preview then.
            let block = u64::from(truth.block_side).pow(2).max(1);
            let judged = pixels.div_ceil(block);
            let bytes_a_pixel = BYTES_A_PIXEL + BYTES_A_MASK * rows as u64;
            out.rows += rows;
            out.pixels += pixels;
            let preview_samples = if block > 1 {
                PREVIEW_SAMPLES.min(truth.samples).min(max_samples as u32)
            } else {
                0
            };
            let preview_rays = pixels.saturating_mul(preview_samples.into());
            let judged_rays = judged.saturating_mul(rays_a_pixel);
            out.rays = out
                .rays
                .saturating_add(judged_rays.saturating_add(preview_rays));
            out.bytes = out.bytes.max(pixels * bytes_a_pixel);
        }
        Ok(out)
    }

    /// Returns the work of one scene: its pixels times its rows.
    pub(super) fn work(&self) -> u64 {
        self.pixels * self.rows as u64
    }
}

fn pixels(size: UVec2) -> u64 {
    u64::from(size.x) * u64::from(size.y)
}

/// Estimates the duration of comparing these scenes.
///
/// Compares the largest scene at two small sizes: the time per additional pixel doesn't depend on
/// the size.
///
/// # Errors
/// Errors if the scene can't be compared.
pub fn pilot(
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
) -> Result<Duration, LabError> {
    let mut sizes = Vec::new();
    for input in inputs {
        let (camera, _) = input.camera_and_light()?;
        sizes.push(input.options_or(options).camera(camera).size);
    }
    let largest = inputs
        .iter()
        .zip(&sizes)
        .max_by_key(|(_, size)| pixels(**size));
    let Some((input, &size)) = largest else {
        return Ok(Duration::ZERO);
    };
    // Disable stored truth: its time would be missing from the estimate.
    let kept_truth = backends.kept_truth.take();
    let seconds = run_pilot(input, options, size, backends);
    backends.kept_truth = kept_truth;
    let PilotTimes { small, large } = seconds?;
    let wanted: Vec<u64> = sizes.iter().map(|&size| pixels(size)).collect();
    Ok(Duration::from_secs_f64(extrapolate_time(
        small, large, &wanted,
    )))
}

/// The times of a scene at two small sizes.
struct PilotTimes {
    small: PilotTime,
    large: PilotTime,
}

fn run_pilot(
    input: &SceneInput,
    options: &CompareOptions,
    size: UVec2,
    backends: &mut Backends,
) -> Result<PilotTimes, LabError> {
    let small_size = reduce_size(size, SMALL_PILOT);
    let large_size = reduce_size(size, LARGE_PILOT);
    // The first run also compiles shaders.
    once(input, options, small_size, backends)?;
    let small = PilotTime {
        pixels: pixels(small_size),
        seconds: once(input, options, small_size, backends)?,
    };
    let large = PilotTime {
        pixels: pixels(large_size),
        seconds: once(input, options, large_size, backends)?,
    };
    Ok(PilotTimes { small, large })
}

/// Duration of a pilot image.
#[derive(Clone, Copy, Debug)]
struct PilotTime {
    pixels: u64,
    seconds: f64,
}

/// Extrapolates the total seconds for images with these numbers of pixels from those of two sizes.
/// Linear in the pixels, and never decreasing.
fn extrapolate_time(small: PilotTime, large: PilotTime, wanted: &[u64]) -> f64 {
    let more_pixels = large.pixels.max(small.pixels + 1) - small.pixels;
    let a_pixel = ((large.seconds - small.seconds) / more_pixels as f64).max(0.0);
    let fixed = (small.seconds - a_pixel * small.pixels as f64).max(0.0);
    wanted
        .iter()
        .map(|&pixels| fixed + a_pixel * pixels as f64)
        .sum()
}

/// Returns an image size with the same aspect ratio and at most `most` pixels.
fn reduce_size(size: UVec2, most: u64) -> UVec2 {
    let by = (most as f64 / pixels(size) as f64).sqrt().min(1.0);
    (size.as_dvec2() * by).floor().as_uvec2().max(UVec2::ONE)
}

/// Returns the seconds of a comparison at this image size with the minimum number of timed runs.
///
/// It runs without timed runs. The time from the first row on is multiplied instead.
fn once(
    input: &SceneInput,
    options: &CompareOptions,
    size: UVec2,
    backends: &mut Backends,
) -> Result<f64, LabError> {
    let own = input.options_or(options);
    let untimed = CompareOptions {
        size: Some(size),
        runs: None,
        ..own.clone()
    };
    let input = SceneInput {
        options: None,
        ..input.clone()
    };
    let start = Instant::now();
    let first_row = Mutex::new(None);
    let note_first_row = |event: CompareEvent<'_>| {
        if let (CompareEvent::Row { .. }, Ok(mut first)) = (event, first_row.lock()) {
            first.get_or_insert_with(Instant::now);
        }
    };
    compare(
        std::slice::from_ref(&input),
        &untimed,
        backends,
        &mut |_, _| Ok(()),
        &note_first_row,
    )?;
    let end = Instant::now();
    let rows_from = first_row
        .lock()
        .ok()
        .and_then(|first| *first)
        .unwrap_or(end);
    // A timed row is rendered once for its mask, and then in turn with its yardstick.
    let supports = own
        .runs
        .map_or(1.0, |runs| 1.0 + 1.25 * f64::from(runs.min.max(1)));
    Ok((rows_from - start).as_secs_f64() + supports * (end - rows_from).as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_cpu::Cpu;
    use umbrage_plan::truth::TruthOptions;

    fn input(name: &str) -> SceneInput {
        let scene = (umbrage_scenes::find(name).expect("built in").build)();
        SceneInput::new(scene, "")
    }

    #[test]
    fn a_huge_image_is_counted_before_it_is_made() {
        let options = CompareOptions {
            techniques: vec!["hard".into()],
            size: Some(UVec2::splat(16_384)),
            ..CompareOptions::quick()
        };
        let sun = Expected::new(&[input("cubes")], &options, 2).expect("valid");
        let lamp = Expected::new(&[input("teapot-lamp")], &options, 2).expect("valid");
        assert_eq!((sun.pixels, sun.rows, sun.rays), (1 << 28, 6, 7 << 28));
        // 256 rays in penumbrae, and six probes of 16.
        assert_eq!(lamp.rays, (256 + 96) << 28);
        assert!(sun.bytes > 50 << 30, "{} GiB", sun.bytes >> 30);
        let both =
            Expected::new(&[input("cubes"), input("teapot-lamp")], &options, 2).expect("valid");
        assert_eq!((both.scenes, both.rows, both.pixels), (2, 12, 2 << 28));
        assert_eq!(
            (both.rays, both.bytes),
            (sun.rays + lamp.rays, lamp.bytes),
            "one scene at a time"
        );
    }

    #[test]
    fn time_grows_with_pixels_alone() {
        let small = |seconds| PilotTime {
            pixels: 1000,
            seconds,
        };
        let large = |seconds| PilotTime {
            pixels: 3000,
            seconds,
        };
        assert!((extrapolate_time(small(3.0), large(5.0), &[1_000_000]) - 1002.0).abs() < 1e-6);
        assert!((extrapolate_time(small(3.0), large(5.0), &[1000, 2000]) - 7.0).abs() < 1e-9);
        assert_eq!(
            extrapolate_time(small(5.0), large(3.0), &[1_000_000]),
            5.0,
            "noise must not make it negative"
        );
    }

    #[test]
    fn a_pilot_keeps_the_images_shape_and_ends() {
        assert_eq!(reduce_size(UVec2::splat(16_384), 64 * 48), UVec2::splat(55));
        assert_eq!(
            reduce_size(UVec2::new(16_384, 2), 64 * 48),
            UVec2::new(5016, 1)
        );
        assert_eq!(reduce_size(UVec2::new(8, 6), 64 * 48), UVec2::new(8, 6));
        let truth = TruthOptions {
            samples: 4,
            probe_samples: 4,
            ..TruthOptions::default()
        };
        let options = CompareOptions {
            techniques: vec!["hard".into()],
            size: Some(UVec2::splat(2048)),
            truth,
            ..CompareOptions::quick()
        };
        let mut cpu = Backends::from_backends(vec![Box::new(Cpu::new())]);
        let found = pilot(&[input("cubes")], &options, &mut cpu).expect("valid");
        assert!(found > Duration::ZERO, "{found:?}");
        assert_eq!(
            pilot(&[], &options, &mut cpu).expect("nothing"),
            Duration::ZERO
        );
    }
}
