//! Truth for what the camera sees, from coarse to fine, in small steps. On the desktop a thread
//! does them, in browsers the frames do.

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

/// Rays per pixel for lights with an extent.
const RAYS: u32 = 256;
/// Sides of the blocks of pixels that share a value, from pass to pass.
const PASSES: [u32; 4] = [8, 4, 2, 1];
/// Pixels traced in a step.
const STEP: usize = 4096;
/// Pixels traced in a step inside frames of browsers, for lights with an extent: each pixel takes
/// hundreds of rays.
const STEP_OF_FRAMES: usize = 128;
/// Pixels checked for ambiguity in a step. Many, since each step copies what the moved cameras see.
const CHECKED: usize = 16_384;
/// Pixels checked in a step for lights with an extent.
const CHECKED_OF_EXTENTS: usize = 2048;

/// Truth as far as it is known.
#[derive(Clone)]
pub(crate) struct TruthSoFar {
    pub receivers: Arc<Receivers>,
    /// Visible share of the light, 0..=1, rows from the top. A pixel that is not traced yet has the
    /// value of its block's first pixel.
    pub visibility: Vec<f32>,
    /// Pixels that are not traced yet are `Unsampled`. Pixels whose truth depends on rounding are
    /// `Ambiguous` once that is checked.
    pub pixels: Vec<Pixel>,
    /// Whether ambiguity is checked.
    pub is_checked: bool,
    /// 0..=1.
    pub progress: f32,
}

/// Truth that is being traced.
struct TruthJob {
    subject: Subject,
    so_far: TruthSoFar,
    pass: usize,
    /// Pixels of this pass that are still to be traced or checked, the next one last.
    waiting: Vec<u32>,
    /// Pixels that were traced, and those that were checked or need no check.
    done: usize,
    /// Pixels that receive.
    all: usize,
    /// Receivers of cameras that are moved by as much as rounding may move them.
    moved: Vec<(Camera, Receivers)>,
}

impl TruthJob {
    /// Finds the receivers.
    ///
    /// # Errors
    /// Errors if the camera is not valid.
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

    /// Traces or checks some pixels. Returns whether a pass ended, so that there is something new
    /// to show.
    ///
    /// # Errors
    /// Errors if the light is not valid.
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
        // Half of the work is to trace, the other half to check.
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

    /// Finds pixels at which truth depends on rounding, as `compare` does.
    fn check(&mut self, pixels: &[u32]) -> Result<()> {
        let request = TruthRequest {
            camera: &self.subject.camera,
            geometry: &self.subject.geometry,
            receivers: &self.so_far.receivers,
            pixels,
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
            // All steps move the camera to the same four positions.
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

    /// Returns the pixels to trace in this pass; behind the last pass, the pixels to check. The
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

/// Truth that a thread traces. Dropping it cancels that.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) type Tracing = Job<TruthSoFar>;

/// Starts to trace truth, which is published after each pass.
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

    /// Least and most time for truth in a frame. It gets half of what the frame itself takes.
    const SLICES: [Duration; 2] = [Duration::from_millis(10), Duration::from_millis(250)];

    /// Truth that frames trace, a little in each.
    pub(crate) struct Tracing {
        ctx: egui::Context,
        /// Until the job begins.
        subject: Option<Subject>,
        job: Option<TruthJob>,
        /// End of the last slice.
        last: Option<Instant>,
    }

    /// Starts to trace truth, which is returned after each pass.
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
        /// Traces for a while. Returns truth if a pass ended.
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
    /// Returns truth of four pixels in a row, of which the last is not traced yet.
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
