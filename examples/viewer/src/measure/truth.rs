//! Truth for what the camera sees, from coarse to fine, in small steps: a thread of its own plays them on the desktop, and frames do in
//! browsers, which have no threads.

use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Camera, Geometry, Light, Receivers,
    cpu::Cpu,
    metrics::Pixel,
    plan::truth::{self, ReceiverPoint, TruthOptions, trace_pixels, trace_points},
};

/// Sides of the blocks of pixels that share a value, from pass to pass.
const PASSES: [u32; 4] = [8, 4, 2, 1];
/// Pixels traced in a step.
const STEP: usize = 4096;
/// The same in browsers, inside frames, for lights with an extent: each pixel takes hundreds of rays.
const STEP_OF_FRAMES: usize = 128;

/// Pixels of which a step finds out whether truth hangs on rounding there. Many, since each step copies what the moved cameras see.
const CHECKED: usize = 16_384;
/// The same for lights with an extent: each pixel takes hundreds of rays.
const CHECKED_OF_EXTENTS: usize = 2048;

/// What is asked for.
#[derive(Clone)]
pub(crate) struct TruthRequest {
    pub camera: Camera,
    pub geometry: Geometry,
    pub light: Light,
    /// Rays for each pixel of lights with an extent.
    pub samples: u32,
    /// Counted up by who asks.
    pub number: u64,
}

/// Truth as far as it is known.
#[derive(Clone)]
pub(crate) struct TruthSoFar {
    pub number: u64,
    pub receivers: Arc<Receivers>,
    /// Share of the light that is seen, 0..=1, rows from the top: that of the block's first pixel where a pixel itself isn't traced yet.
    pub visibility: Vec<f32>,
    /// Whether the pixel itself was traced.
    pub is_traced: Vec<bool>,
    /// Whether the pixel faces away from the light, is out of its cone, or receives nothing: it counts in no error.
    pub is_left_out: Vec<bool>,
    /// Whether truth changes there as the image moves by what rounding may come to: such pixels count in no error, as in `compare`.
    pub is_ambiguous: Vec<bool>,
    /// Whether that is known.
    pub is_checked: bool,
    /// 0..=1.
    pub progress: f32,
}

/// Truth that is being traced.
pub(crate) struct TruthJob {
    request: TruthRequest,
    pub so_far: TruthSoFar,
    pass: usize,
    /// Pixels of this pass that are still to be traced, the next one last.
    waiting: Vec<u32>,
    traced: usize,
    /// Pixels of which is known whether truth hangs on rounding, among those that receive.
    checked: usize,
    /// Pixels that receive.
    all: usize,
    /// What cameras see that are moved by what rounding may come to.
    moved: Vec<(Camera, Receivers)>,
}

impl TruthJob {
    /// Finds what the camera sees.
    ///
    /// # Errors
    /// Errors if the camera is not valid.
    pub(crate) fn new(request: TruthRequest) -> Result<Self> {
        let receivers = Arc::new(Cpu::new().receivers(&request.camera, &request.geometry)?);
        let count = receivers.len();
        let mut job = Self {
            so_far: TruthSoFar {
                number: request.number,
                visibility: vec![1.0; count],
                is_traced: vec![false; count],
                is_left_out: receivers
                    .receives
                    .iter()
                    .map(|receives| !receives)
                    .collect(),
                is_ambiguous: vec![false; count],
                is_checked: false,
                receivers,
                progress: 0.0,
            },
            checked: 0,
            all: 0,
            moved: Vec::new(),
            request,
            pass: 0,
            waiting: Vec::new(),
            traced: 0,
        };
        let left_out = &job.so_far.is_left_out;
        job.all = left_out.iter().filter(|&&is_left_out| !is_left_out).count();
        job.waiting = job.pixels_of_pass();
        Ok(job)
    }

    /// Whether all is known.
    pub(crate) fn is_done(&self) -> bool {
        self.so_far.is_checked
    }

    /// Traces some pixels, or finds out of some whether truth hangs on rounding there. Returns whether a pass ended, so that there is
    /// something new to show.
    ///
    /// # Errors
    /// Errors if the light is not valid.
    pub(crate) fn step(&mut self) -> Result<bool> {
        let ends = if self.pass < PASSES.len() {
            self.trace()?
        } else {
            self.check()?
        };
        // Half of it is to trace, the other half to check.
        let share = (self.traced + self.checked) as f32 / (2 * self.all.max(1)) as f32;
        self.so_far.progress = if self.is_done() {
            1.0
        } else {
            share.min(0.999)
        };
        Ok(ends)
    }

    fn trace(&mut self) -> Result<bool> {
        let is_quick = cfg!(not(target_arch = "wasm32")) || self.request.light.is_ideal();
        let step = if is_quick { STEP } else { STEP_OF_FRAMES };
        let rest = self.waiting.len().saturating_sub(step);
        let pixels = self.waiting.split_off(rest);
        let so_far = &mut self.so_far;
        let point = |&i: &u32| {
            ReceiverPoint::of_pixel(
                &self.request.camera,
                &self.request.geometry,
                &so_far.receivers,
                i as usize,
            )
        };
        let points: Vec<_> = pixels.iter().map(point).collect();
        let options = TruthOptions {
            samples: self.request.samples,
            penumbra_factor: 1,
            ..TruthOptions::default()
        };
        let traced = trace_points(
            &self.request.geometry,
            &self.request.light,
            &points,
            &options,
        )?;
        let side = PASSES[self.pass];
        let size = so_far.receivers.size;
        for (&i, truth) in pixels.iter().zip(&traced) {
            let [x, y] = [i % size.x, i / size.x];
            so_far.is_traced[i as usize] = true;
            so_far.is_left_out[i as usize] = truth.unlit;
            for by in y..(y + side).min(size.y) {
                for bx in x..(x + side).min(size.x) {
                    let block = (by * size.x + bx) as usize;
                    if block == i as usize || !so_far.is_traced[block] {
                        so_far.visibility[block] = truth.visibility;
                    }
                }
            }
        }
        self.traced += pixels.len();
        if !self.waiting.is_empty() {
            return Ok(false);
        }
        self.pass += 1;
        self.waiting = if self.pass < PASSES.len() {
            self.pixels_of_pass()
        } else {
            self.pixels_that_count()
        };
        Ok(true)
    }

    /// Finds out of some pixels whether truth hangs on rounding there, as `compare` does.
    fn check(&mut self) -> Result<bool> {
        let step = if self.request.light.is_ideal() {
            CHECKED
        } else {
            CHECKED_OF_EXTENTS
        };
        let rest = self.waiting.len().saturating_sub(step);
        let pixels = self.waiting.split_off(rest);
        let request = truth::TruthRequest {
            camera: &self.request.camera,
            geometry: &self.request.geometry,
            receivers: &self.so_far.receivers,
            pixels: &pixels,
        };
        // Visibility is known already.
        let options = TruthOptions {
            samples: 1,
            penumbra_factor: 1,
            ..TruthOptions::default()
        };
        let moved = &mut self.moved;
        let mut cpu = Cpu::new();
        let mut find = |camera: &Camera, geometry: &Geometry| {
            // The same four cameras for all steps.
            if let Some((_, known)) = moved.iter().find(|(of, _)| of == camera) {
                return Ok(known.clone());
            }
            let receivers = cpu.receivers(camera, geometry)?;
            moved.push((*camera, receivers.clone()));
            Ok(receivers)
        };
        let light = &self.request.light;
        let found = trace_pixels(&request, light, &options, &mut find, &|_, _| {})?;
        for (&i, truth) in pixels.iter().zip(&found) {
            self.so_far.is_ambiguous[i as usize] = truth.pixel == Pixel::Ambiguous;
        }
        self.checked += pixels.len();
        self.so_far.is_checked = self.waiting.is_empty();
        Ok(self.so_far.is_checked)
    }

    /// Returns the pixels that count in errors, as far as truth is known.
    fn pixels_that_count(&mut self) -> Vec<u32> {
        let left_out = &self.so_far.is_left_out;
        let out: Vec<u32> = (0..left_out.len() as u32)
            .filter(|&i| !left_out[i as usize])
            .collect();
        // Of the others nothing is to be found out.
        self.checked = self.all.saturating_sub(out.len());
        out
    }

    fn pixels_of_pass(&self) -> Vec<u32> {
        let side = PASSES[self.pass];
        let size = self.so_far.receivers.size;
        let mut out = Vec::new();
        for y in (0..size.y).step_by(side as usize).rev() {
            for x in (0..size.x).step_by(side as usize).rev() {
                let i = y * size.x + x;
                let receives = self.so_far.receivers.receives[i as usize];
                if receives && !self.so_far.is_traced[i as usize] {
                    out.push(i);
                }
            }
        }
        out
    }
}
