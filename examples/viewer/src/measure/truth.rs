//! Truth for what the camera sees, from coarse to fine, in small steps: a thread of its own plays them on the desktop, and frames do in
//! browsers, which have no threads.

use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Camera, Geometry, Light, Receivers,
    cpu::Cpu,
    plan::truth::{ReceiverPoint, TruthOptions, trace_points},
};

/// Sides of the blocks of pixels that share a value, from pass to pass.
const PASSES: [u32; 4] = [8, 4, 2, 1];
/// Pixels traced in a step.
const STEP: usize = 4096;
/// The same in browsers, inside frames, for lights with an extent: each pixel takes hundreds of rays.
const STEP_OF_FRAMES: usize = 128;

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
pub(crate) struct TruthSoFar {
    pub number: u64,
    pub receivers: Arc<Receivers>,
    /// Share of the light that is seen, 0..=1, rows from the top: that of the block's first pixel where a pixel itself isn't traced yet.
    pub visibility: Vec<f32>,
    /// Whether the pixel itself was traced.
    pub is_traced: Vec<bool>,
    /// Whether the pixel faces away from the light, is out of its cone, or receives nothing: it counts in no error.
    pub is_left_out: Vec<bool>,
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
    /// Pixels that receive.
    all: usize,
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
                receivers,
                progress: 0.0,
            },
            all: 0,
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

    /// Whether all is traced.
    pub(crate) fn is_done(&self) -> bool {
        self.pass == PASSES.len()
    }

    /// Traces some pixels. Returns whether a pass ended, so that there is something new to show.
    ///
    /// # Errors
    /// Errors if the light is not valid.
    pub(crate) fn step(&mut self) -> Result<bool> {
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
        so_far.progress = self.traced as f32 / self.all.max(1) as f32;
        if !self.waiting.is_empty() {
            return Ok(false);
        }
        self.pass += 1;
        if !self.is_done() {
            self.waiting = self.pixels_of_pass();
        }
        Ok(true)
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
