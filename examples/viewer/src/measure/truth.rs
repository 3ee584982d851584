//! Progressive tracing of the reference for the camera's view, from coarse to fine. On the desktop
//! it runs on a thread, in browsers within frames.

use super::subject::Subject;
#[cfg(not(target_arch = "wasm32"))]
use crate::job::Job;
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Camera, Geometry, Receivers,
    cpu::Cpu,
    metrics::Pixel,
    plan::truth::{ReceiverPoint, TruthOptions, TruthRequest, trace_pixels, trace_points},
};

/// Rays per pixel for area lights.
const RAYS: u32 = 256;
/// Sides of the blocks of pixels that share a value, from pass to pass.
const PASSES: [u32; 4] = [8, 4, 2, 1];
/// Pixels traced in a step.
const STEP: usize = 4096;
/// Pixels traced in a step within frames of browsers, for area lights: each pixel takes hundreds of
/// rays.
const STEP_OF_FRAMES: usize = 128;
/// Pixels checked for ambiguity in a step. It is large, since each step copies the receivers of the
/// moved cameras.
const CHECKED: usize = 16_384;
/// Pixels checked in a step for area lights.
const CHECKED_OF_EXTENTS: usize = 2048;

/// The reference as far as it is known.
#[derive(Clone)]
pub(crate) struct TruthSoFar {
    pub receivers: Arc<Receivers>,
    /// Visible fraction of the light, 0..=1, rows from the top. A pixel that is not yet traced has
    /// the value of its block's first pixel.
    pub visibility: Vec<f32>,
    /// State of each pixel. Pixels that are not yet traced are `Unsampled`. Pixels whose reference
    /// depends on rounding are `Ambiguous` after the check.
    pub pixels: Vec<Pixel>,
    /// `true` if ambiguity is checked.
    pub is_checked: bool,
    /// Progress, 0..=1.
    pub progress: f32,
}

/// A reference that is being traced.
struct TruthJob {
    subject: Subject,
    so_far: TruthSoFar,
    pass: usize,
    /// Remaining pixels of this pass, the next one last.
    waiting: Vec<u32>,
    /// Number of pixels that were traced, plus those that were checked or need no check.
    done: usize,
    /// Number of pixels with receivers.
    all: usize,
    /// Receivers of cameras that are moved by the possible rounding error.
    moved: Vec<(Camera, Receivers)>,
}

impl TruthJob {
    /// Finds the receivers.
    ///
    /// # Errors
    /// Returns an error if the camera is not valid.
    fn new(subject: Subject) -> Result<Self> {
        let receivers = Arc::new(Cpu::new().receivers(&subject.camera, &subject.geometry)?);
        let class = |&receives: &bool| match receives {
            true => Pixel::Unsampled,
            false => Pixel::Empty,
        };
        let pixels: Vec<Pixel> = receivers.receives.iter().map(class).collect();
        let mut job = Self {
            subject,
            pass: 0,
            waiting: Vec::new(),
            done: 0,
            all: pixels.iter().filter(|&&p| p == Pixel::Unsampled).count(),
            moved: Vec::new(),
            so_far: TruthSoFar {
                visibility: vec![1.0; pixels.len()],
                pixels,
                receivers,
                is_checked: false,
                progress: 0.0,
            },
        };
        job.waiting = job.pixels_of_pass();
        Ok(job)
    }

    /// Traces or checks some pixels. Returns whether a pass ended, which changes the result.
    ///
    /// # Errors
    /// Returns an error if the light is not valid.
    fn step(&mut self) -> Result<bool> {
        let is_tracing = self.pass < PASSES.len();
        let is_ideal = self.subject.light.is_ideal();
        let count = match (is_tracing, is_ideal) {
            (true, false) if cfg!(target_arch = "wasm32") => STEP_OF_FRAMES,
            (true, _) => STEP,
            (false, true) => CHECKED,
            (false, false) => CHECKED_OF_EXTENTS,
        };
        let rest = self.waiting.len().saturating_sub(count);
        let pixels = self.waiting.split_off(rest);
        if is_tracing {
            self.trace(&pixels)?;
        } else {
            self.check(&pixels)?;
        }
        self.done += pixels.len();
        let ends = self.waiting.is_empty();
        if ends && is_tracing {
            self.pass += 1;
            self.waiting = self.pixels_of_pass();
        } else if ends {
            self.so_far.is_checked = true;
        }
        // Tracing is half of the work, checking the other half.
        let share = self.done as f32 / (2 * self.all.max(1)) as f32;
        self.so_far.progress = if self.so_far.is_checked {
            1.0
        } else {
            share.min(0.999)
        };
        Ok(ends)
    }

    fn trace(&mut self, pixels: &[u32]) -> Result<()> {
        let Subject {
            camera,
            light,
            geometry,
            ..
        } = &self.subject;
        let so_far = &mut self.so_far;
        let point =
            |&i: &u32| ReceiverPoint::of_pixel(camera, geometry, &so_far.receivers, i as usize);
        let points: Vec<_> = pixels.iter().map(point).collect();
        let options = TruthOptions {
            samples: RAYS,
            penumbra_factor: 1,
            ..TruthOptions::default()
        };
        let traced = trace_points(geometry, light, &points, &options)?;
        let side = PASSES[self.pass];
        let size = so_far.receivers.size;
        for (&i, truth) in pixels.iter().zip(&traced) {
            so_far.pixels[i as usize] = match truth.unlit {
                true => Pixel::Unlit,
                false => Pixel::Counted,
            };
            so_far.visibility[i as usize] = truth.visibility;
            let [x, y] = [i % size.x, i / size.x];
            for by in y..(y + side).min(size.y) {
                for bx in x..(x + side).min(size.x) {
                    let other = (by * size.x + bx) as usize;
                    if matches!(so_far.pixels[other], Pixel::Unsampled | Pixel::Empty) {
                        so_far.visibility[other] = truth.visibility;
                    }
                }
            }
        }
        Ok(())
    }

    /// Finds pixels at which the reference depends on rounding, like `compare`.
    fn check(&mut self, pixels: &[u32]) -> Result<()> {
        let request = TruthRequest {
            camera: &self.subject.camera,
            geometry: &self.subject.geometry,
            receivers: &self.so_far.receivers,
            pixels,
        };
        // Visibility is already known.
        let options = TruthOptions {
            samples: 1,
            penumbra_factor: 1,
            ..TruthOptions::default()
        };
        let moved = &mut self.moved;
        let mut cpu = Cpu::new();
        let mut find = |camera: &Camera, geometry: &Geometry| {
            // Reuse receivers: all steps move the camera to the same four positions.
            if let Some((_, known)) = moved.iter().find(|(of, _)| of == camera) {
                return Ok(known.clone());
            }
            let receivers = cpu.receivers(camera, geometry)?;
            moved.push((*camera, receivers.clone()));
            Ok(receivers)
        };
        let light = &self.subject.light;
        let found = trace_pixels(&request, light, &options, &mut find, &|_, _| {})?;
        for (&i, truth) in pixels.iter().zip(&found) {
            if truth.pixel == Pixel::Ambiguous {
                self.so_far.pixels[i as usize] = Pixel::Ambiguous;
            }
        }
        Ok(())
    }

    /// Returns the pixels to trace in this pass, or after the last pass, the pixels to check. The
    /// next one is the last.
    fn pixels_of_pass(&mut self) -> Vec<u32> {
        let pixels = &self.so_far.pixels;
        let Some(&side) = PASSES.get(self.pass) else {
            let counted = (0..).zip(pixels).filter(|(_, p)| **p == Pixel::Counted);
            let out: Vec<u32> = counted.map(|(i, _)| i).collect();
            self.done = (2 * self.all).saturating_sub(out.len());
            return out;
        };
        let size = self.so_far.receivers.size;
        let mut out = Vec::new();
        for y in (0..size.y).step_by(side as usize).rev() {
            for x in (0..size.x).step_by(side as usize).rev() {
                let i = y * size.x + x;
                if pixels[i as usize] == Pixel::Unsampled {
                    out.push(i);
                }
            }
        }
        out
    }
}

/// A reference that a thread traces. Dropping it cancels the thread's work.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) type Tracing = Job<TruthSoFar>;

/// Starts to trace the reference, which is published after each pass.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn start(ctx: &egui::Context, subject: Subject) -> Tracing {
    Job::start(ctx, move |progress| {
        let mut job = TruthJob::new(subject)?;
        while !job.so_far.is_checked {
            if progress.cancel.is_cancelled() {
                return Ok(None);
            }
            if job.step()? {
                progress.publish(Ok(job.so_far.clone()));
            }
        }
        Ok(None)
    })
}

#[cfg(target_arch = "wasm32")]
pub(crate) use frames::{Tracing, start};

#[cfg(target_arch = "wasm32")]
mod frames {
    use super::{Subject, TruthJob, TruthSoFar};
    use anyhow::Result;
    use web_time::{Duration, Instant};

    /// Least and greatest time for tracing in a frame. The time is half of that of the frame
    /// itself.
    const SLICES: [Duration; 2] = [Duration::from_millis(10), Duration::from_millis(250)];

    /// A reference that is traced in slices within frames.
    pub(crate) struct Tracing {
        ctx: egui::Context,
        /// The subject, until the job begins.
        subject: Option<Subject>,
        job: Option<TruthJob>,
        /// End of the last slice.
        last: Option<Instant>,
    }

    /// Starts to trace the reference, which is returned after each pass.
    pub(crate) fn start(ctx: &egui::Context, subject: Subject) -> Tracing {
        ctx.request_repaint();
        Tracing {
            ctx: ctx.clone(),
            subject: Some(subject),
            job: None,
            last: None,
        }
    }

    impl Tracing {
        /// Traces for a while. Returns the reference if a pass ended.
        pub(crate) fn take(&mut self) -> Option<Result<TruthSoFar>> {
            let outcome = self.advance().transpose();
            if let Some(Err(_)) = outcome {
                self.job = None;
            } else if self.job.as_ref().is_some_and(|job| !job.so_far.is_checked) {
                self.ctx.request_repaint();
            }
            outcome
        }

        fn advance(&mut self) -> Result<Option<TruthSoFar>> {
            if let Some(subject) = self.subject.take() {
                self.job = Some(TruthJob::new(subject)?);
                return Ok(None);
            }
            let begin = Instant::now();
            let Some(job) = &mut self.job else {
                return Ok(None);
            };
            let frame = self.last.map_or(Duration::ZERO, |last| begin - last);
            let slice = (frame / 2).clamp(SLICES[0], SLICES[1]);
            let mut ends = false;
            while !job.so_far.is_checked && begin.elapsed() < slice && !ends {
                ends = job.step()?;
            }
            self.last = Some(Instant::now());
            Ok(ends.then(|| job.so_far.clone()))
        }
    }
}

#[cfg(test)]
impl TruthSoFar {
    /// Returns a reference of four pixels in a row, of which the last is not yet traced.
    pub(crate) fn of_test() -> Self {
        let receivers = Receivers::empty(umbrage::glam::UVec2::new(4, 1));
        Self {
            receivers: receivers.into(),
            visibility: vec![0.0, 1.0, 0.5, 1.0],
            pixels: [[Pixel::Counted; 3].as_slice(), &[Pixel::Unsampled]].concat(),
            is_checked: false,
            progress: 1.0,
        }
    }
}
