//! Moving cases: changes of visibility from frame to frame at fixed points.
//!
//! The points are the receivers of the first frame's pixels that are near shadow edges and visible
//! in all frames. For each frame a technique's map is fitted to that frame's camera, redrawn, and
//! looked up at these same points.
//!
//! Two kinds of technique are *not measured* while only the camera moves. Those that cast into the
//! camera's own image (planar shadows, volumes) have visibilities only at that camera's pixels, so
//! they always run with the first camera. Those without a map (rays) don't depend on the camera if
//! their visibility at a point never changes.
//!
//! While the camera moves, its images show the points at other pixels: the point at pixel (x, y) in
//! the first frame is at (x + 1, y) in the second, and so on. So patterns and noise that follow the
//! pixel (dithered or rotated taps, random rays) change at a point, as they do on a screen.
//!
//! Figures are the first backend's. The others render the first and the last frame, which differ
//! most, and must agree there.

use super::{
    all_backends,
    case_truth::{CaseTruth, visibility_at_receivers},
    cell::{Cell, CellOutcome},
    criterion::Criterion,
    guard::{self, NoMask},
    measure::Measure,
    measures::shimmer::{change, change_error, shimmer},
    pictures,
    still::{cell, no_mask},
    threads::SharedBackends,
    verdict::{Judgement, Verdict, VerdictLimits},
};
use crate::error::LabError;
use glam::Vec3;
use std::sync::Arc;
use umbrage_core::{Camera, Geometry, Invalid, Light, Receivers, Recipe, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_plan::{
    motion::{draws_the_picture, pixel_shift},
    truth::TruthOptions,
};
use umbrage_scenes::motion::{Motion, MotionStep, texel_width};
use umbrage_techniques::TechniquePreset;

/// Camera, light and casters of one frame.
#[derive(Clone, Debug)]
pub struct MotionFrame {
    /// The scene's triangles.
    pub geometry: Geometry,
    /// The camera.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// The receivers at the camera's pixels.
    pub receivers: Receivers,
}

/// A moving case, ready to run.
#[derive(Clone, Debug)]
pub struct Moving {
    /// Truth of its first frame.
    pub case_truth: Arc<CaseTruth>,
    /// All frames, including the first.
    pub frames: Vec<MotionFrame>,
    /// True visibility at the first frame's receivers, frame by frame.
    pub truth: Vec<Vec<f32>>,
    /// Marks the first frame's receivers that count.
    pub marked: Vec<bool>,
    /// The motion.
    pub motion: Motion,
}

impl Moving {
    /// Moves the case's camera or light through `count` frames, and traces truth.
    ///
    /// # Errors
    /// Errors if the scene contains unusable numbers.
    pub fn new(
        case_truth: &Arc<CaseTruth>,
        motion: Motion,
        count: u32,
        options: &TruthOptions,
    ) -> Result<Self, LabError> {
        let mut cpu = Cpu::new();
        let texel = first_texel(case_truth)?;
        let mut frames = Vec::new();
        let mut truth = Vec::new();
        // Place each frame's camera, light and casters, and trace truth at the first frame's
        // receivers.
        for index in 0..count {
            let step = MotionStep {
                index,
                count,
                texel,
            };
            let camera = motion.camera(&case_truth.camera, &step);
            let light = motion.light(&case_truth.lights[0], &step);
            let geometry = geometry_at(case_truth, motion, &step)?;
            let receivers = cpu.receivers(&camera, &geometry)?;
            truth.push(visibility_at_receivers(
                &geometry,
                &light,
                &case_truth.truth,
                options,
            )?);
            frames.push(MotionFrame {
                geometry,
                camera,
                light,
                receivers,
            });
        }
        // Mark the points near shadow edges that are visible in all frames.
        let marked = (0..case_truth.open.len())
            .map(|i| is_marked(case_truth, &frames, i))
            .collect();
        Ok(Self {
            case_truth: case_truth.clone(),
            frames,
            truth,
            marked,
            motion,
        })
    }

    /// Returns a measure's figure of the masks, one per frame, at the first frame's receivers. It
    /// is the excess change, or for measures of a single mask the first frame's figure.
    pub fn figure(&self, measure: Measure, masks: &[Vec<f32>]) -> f64 {
        let width = self.case_truth.truth.size.x as usize;
        match measure {
            Measure::ChangeError => change_error(masks, &self.truth, &self.marked, width),
            Measure::Shimmer => shimmer(masks, &self.truth, &self.marked),
            of_one_mask => of_one_mask.figure(&self.case_truth, &masks[0]),
        }
    }

    /// Returns the limits of that figure; `limits` are the measure's own ([`Measure::limits`]). If
    /// truth moves, a shadow that stands still fails, however slow the movement: its figure is
    /// truth's own change.
    pub fn limits(&self, measure: Measure, limits: VerdictLimits) -> VerdictLimits {
        match measure {
            Measure::ChangeError => limits.capped_by_no_shadow(change(&self.truth, &self.marked)),
            _ => limits,
        }
    }

    /// Runs one setting and returns its cell.
    pub(super) fn cell(
        &self,
        technique: &TechniquePreset,
        criteria: &[Criterion],
        backends: &SharedBackends<'_>,
    ) -> Result<Cell, LabError> {
        let executed = match self.render_frames(technique, backends) {
            Ok(executed) => executed,
            Err(why) => return Ok(no_mask(technique, why)),
        };
        let mut judgements = Vec::new();
        for criterion in criteria {
            let figure = self.figure(criterion.measure, &executed.masks);
            let cannot_change = match criterion.measure {
                Measure::Shimmer => executed.cannot_change(figure),
                _ => None,
            };
            judgements.push(match cannot_change {
                Some(reason) => Judgement::not_measured(reason),
                None => criterion.limits.judgement(figure),
            });
        }
        let mut out = cell(technique, CellOutcome::from_judgements(judgements));
        out.disagreeing = executed.disagreeing;
        if out.verdict() > Some(Verdict::NotMeasured) {
            let strip = pictures::strip(&self.case_truth, &executed.masks, &self.marked)?;
            out.picture = Some(strip);
        }
        Ok(out)
    }

    /// Renders all frames.
    fn render_frames(
        &self,
        technique: &dyn ShadowTechnique,
        backends: &SharedBackends<'_>,
    ) -> Result<RenderedFrames, NoMask> {
        let mut out = RenderedFrames {
            masks: Vec::new(),
            draws_the_picture: false,
            casts: false,
            disagreeing: None,
        };
        for index in 0..self.frames.len() {
            let is_end = index == 0 || index + 1 == self.frames.len();
            let executed = self.render_frame(index, technique, backends, is_end)?;
            out.masks.push(executed.rendered.mask);
            out.draws_the_picture |= executed.draws_the_picture;
            out.casts |= executed.casts;
            out.disagreeing = all_backends::sum(out.disagreeing, executed.rendered.disagreeing);
        }
        Ok(out)
    }

    /// Renders the mask of frame `index` at the first frame's receivers, on the first backend or on
    /// all.
    fn render_frame(
        &self,
        index: usize,
        technique: &dyn ShadowTechnique,
        backends: &SharedBackends<'_>,
        on_all: bool,
    ) -> Result<RenderedFrame, NoMask> {
        let render = |view: &View<'_>, recipe: &Recipe| {
            let mut backends = backends.lock();
            let own_backends = all_backends::select(&mut backends.backends, on_all);
            all_backends::render(own_backends, view, recipe)
        };
        let frame = &self.frames[index];
        let geometry = &frame.geometry;
        let frame_view = View::new(&frame.camera, &frame.light, geometry);
        let first_view = View::new(&self.case_truth.camera, &frame.light, geometry);
        let at_frame = frame_view.with_receivers(&frame.receivers);
        // Fit the map to the frame's camera; the points are the first frame's.
        let recipe = guard::plan(technique, &at_frame)?;
        let casts = !recipe.casts.is_empty();
        let receivers = &self.case_truth.truth.receivers;
        // Render images from the frame's camera at the first camera's pixels: they can't be read
        // elsewhere.
        if draws_the_picture(&recipe, &frame.camera) {
            let at_first = first_view.with_receivers(receivers);
            let recipe = guard::plan(technique, &at_first)?;
            return Ok(RenderedFrame {
                rendered: render(&at_first, &recipe)?,
                draws_the_picture: true,
                casts,
            });
        }
        // Look up the points at shifted pixels, and shift the mask back.
        let pixels = if self.motion.moves_pixels() { index } else { 0 };
        let shifted_receivers = pixel_shift::to_the_right(receivers, pixels);
        let at_pixels = first_view.with_receivers(&shifted_receivers);
        let mut rendered = render(&at_pixels, &recipe)?;
        pixel_shift::shift_back(&mut rendered.mask, receivers.size.x, pixels);
        Ok(RenderedFrame {
            rendered,
            draws_the_picture: false,
            casts,
        })
    }

    /// Returns the number of points that count.
    pub fn points(&self) -> usize {
        self.marked.iter().filter(|m| **m).count()
    }
}

/// Result of a setting in one frame.
struct RenderedFrame {
    /// The mask at the first frame's receivers.
    rendered: all_backends::RenderedOnAll,
    /// Whether it casts into the camera's own image.
    draws_the_picture: bool,
    /// Whether it draws anything.
    casts: bool,
}

/// Reason why a technique that casts into the camera's own image isn't measured while only the
/// camera moves.
const IN_THE_PICTURE: &str =
    "it draws into the camera's own image, so every frame uses the first frame's camera";
/// Reason why a technique without a map isn't measured then.
const NO_MAP: &str = "it draws no map, so its visibility at a point cannot depend on the camera while the light stands still";

impl RenderedFrames {
    /// Returns the reason why the change of visibility, `figure`, is always 0 while only the camera
    /// moves; `None` if it can change.
    fn cannot_change(&self, figure: f64) -> Option<&'static str> {
        match (self.draws_the_picture, self.casts) {
            (true, _) => Some(IN_THE_PICTURE),
            (false, false) if figure == 0.0 => Some(NO_MAP),
            _ => None,
        }
    }
}

/// Result of a setting over all frames.
struct RenderedFrames {
    /// Mask of each frame from the first backend, at the first frame's receivers.
    masks: Vec<Vec<f32>>,
    /// Whether it casts into the camera's own image.
    draws_the_picture: bool,
    /// Whether it draws anything.
    casts: bool,
    /// Number of decided pixels on which backends differ, over all frames; `None` if no other
    /// backend supports the technique.
    disagreeing: Option<u64>,
}

/// Returns the triangles of a frame.
fn geometry_at(
    case_truth: &CaseTruth,
    motion: Motion,
    step: &MotionStep,
) -> Result<Geometry, Invalid> {
    if motion != Motion::Casters {
        return Ok(case_truth.geometry.clone());
    }
    Geometry::bake(&motion.scene(&case_truth.scene, step))
}

/// Returns the width of a texel of the first frame's map, metres.
fn first_texel(case_truth: &CaseTruth) -> Result<f64, LabError> {
    let view = case_truth
        .view(&case_truth.lights[0])
        .with_receivers(&case_truth.truth.receivers);
    Ok(texel_width(&view, case_truth.map_size)?)
}

/// Reports whether a point counts: it is near a shadow edge, and visible in every frame.
fn is_marked(case_truth: &CaseTruth, frames: &[MotionFrame], i: usize) -> bool {
    case_truth.counts(i)
        && !case_truth.open[i]
        && frames
            .iter()
            .all(|frame| stands_still(case_truth, frame, i) && is_seen(case_truth, frame, i))
}

/// Reports whether the geometry at pixel `i` of the first frame has not moved in another.
fn stands_still(case_truth: &CaseTruth, frame: &MotionFrame, i: usize) -> bool {
    let triangle = case_truth.truth.receivers.triangle[i];
    frame.geometry.corners(triangle) == case_truth.geometry.corners(triangle)
}

/// Reports whether a frame's camera sees the point at pixel `i` of the first frame.
fn is_seen(case_truth: &CaseTruth, frame: &MotionFrame, i: usize) -> bool {
    let camera = &frame.camera;
    let receivers = &case_truth.truth.receivers;
    let position = receivers.position(i);
    let clip = camera.space().clip_from_world() * position.extend(1.0);
    let is_inside = clip.w > 0.0 && clip.x.abs() < clip.w && clip.y.abs() < clip.w;
    let to_eye: Vec3 = camera.eye() - position;
    // Start the ray a thousandth of its length off the surface, so that neighboring triangles don't
    // hide the point.
    let lift = receivers.normal(i) * (1e-3 * to_eye.length());
    let origin = position + lift;
    let direction = to_eye - lift;
    let bvh = frame.geometry.bvh();
    is_inside && !bvh.is_occluded(origin, direction, receivers.triangle[i])
}
