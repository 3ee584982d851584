//! Moving cases: what changes from frame to frame at points that stay.
//!
//! The points are the receivers of the first frame's pixels, near edges of shadows, and seen in all frames. A technique's
//! map is planned and drawn anew for each frame, as its camera sees the scene then, and looked up at these same points.
//! Techniques whose casts go into the camera's own picture (planar shadows, volumes) have an answer at pixels alone: the
//! first camera asks them, so that only the light's motion counts for them. Patterns that turn from pixel to pixel stay
//! with their points, too: what is measured is the map's crawl, not the pattern's.
//!
//! Figures are the first backend's. The others play the first and the last frame, the two that differ most, and must agree
//! there.

use super::{
    Cell, CellOutcome, Verdict, VerdictLimits, all_backends,
    case_truth::{CaseTruth, trace_at_receivers},
    guard::{self, NoMask},
    measure::Measure,
    measures::shimmer::{change, change_error, shimmer},
    pictures,
    play::{cell, draws_the_picture, no_mask},
    row::Motion,
};
use crate::{LabError, compare::Backends};
use glam::{Affine3A, Quat, Vec3};
use umbrage_core::{Backend, Camera, Fit, Layout, Light, Receivers, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::TruthOptions;

/// Who sees and what shines at one moment.
#[derive(Clone, Debug)]
pub struct MotionFrame {
    /// The camera.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// What the camera sees.
    pub receivers: Receivers,
}

/// A moving case, ready to be played.
#[derive(Clone, Debug)]
pub struct Moving<'a> {
    /// Its first frame.
    pub case_truth: &'a CaseTruth,
    /// All frames, the first among them.
    pub frames: Vec<MotionFrame>,
    /// Truth at the first frame's receivers, frame by frame.
    pub truth: Vec<Vec<f32>>,
    /// The points that count.
    pub marked: Vec<bool>,
}

/// Texels that the camera pans by, a frame.
const PAN_TEXELS: f64 = 0.37;
/// Degrees that it yaws by.
const YAW: f64 = 0.1;
/// Degrees that the sun turns by.
const TURN: f64 = 0.25;
/// Vertical fields of view from the first frame to the last, degrees.
const WIDENING: [f64; 2] = [75.0, 90.0];

/// The camera that a motion starts from.
pub(super) fn first_camera(camera: &Camera, motion: Motion) -> Camera {
    if motion == Motion::Widening {
        with_fov(camera, WIDENING[0])
    } else {
        *camera
    }
}

fn with_fov(camera: &Camera, degrees: f64) -> Camera {
    let mut out = *camera;
    let scale = (1.0 / (0.5 * degrees.to_radians()).tan()) as f32;
    out.clip_from_view.x_axis.x *= scale / out.clip_from_view.y_axis.y;
    out.clip_from_view.y_axis.y = scale;
    out
}

impl<'a> Moving<'a> {
    /// Moves the case's camera or light through `count` frames, and traces truth.
    ///
    /// # Errors
    /// When the scene holds numbers that can't be used.
    pub fn new(
        case_truth: &'a CaseTruth,
        motion: Motion,
        count: u32,
        options: &TruthOptions,
    ) -> Result<Self, LabError> {
        let mut cpu = Cpu::new();
        let texel = texel(case_truth)?;
        let mut frames = Vec::new();
        let mut truth = Vec::new();
        for t in 0..count {
            let (camera, light) = at(case_truth, motion, t, count, texel);
            let receivers = cpu.receivers(&camera, &case_truth.geometry)?;
            let seen =
                trace_at_receivers(&case_truth.geometry, &light, &case_truth.truth, options)?;
            truth.push(
                seen.into_iter()
                    .map(|s| s.map_or(1.0, |s| s.visibility))
                    .collect(),
            );
            frames.push(MotionFrame {
                camera,
                light,
                receivers,
            });
        }
        let marked = (0..case_truth.open.len())
            .map(|i| is_marked(case_truth, &frames, i))
            .collect();
        Ok(Self {
            case_truth,
            frames,
            truth,
            marked,
        })
    }

    /// How much the masks of its frames, at the first one's receivers, change though they should not.
    pub fn figure(&self, measure: Measure, masks: &[Vec<f32>]) -> f64 {
        match measure {
            Measure::ChangeError => change_error(
                masks,
                &self.truth,
                &self.marked,
                self.case_truth.truth.size.x as usize,
            ),
            _ => shimmer(masks, &self.truth, &self.marked),
        }
    }

    /// Where that passes and fails. Where truth moves, a shadow that stands still fails, however slow the movement: its
    /// figure is truth's own change.
    pub fn limits(&self, measure: Measure) -> VerdictLimits {
        let limits = measure.limits(self.case_truth);
        match measure {
            Measure::ChangeError => limits.below(change(&self.truth, &self.marked)),
            _ => limits,
        }
    }

    /// One setting's cell.
    pub(super) fn cell(
        &self,
        technique: &dyn ShadowTechnique,
        measure: Measure,
        backends: &mut Backends,
    ) -> Result<Cell, LabError> {
        let (masks, disagreeing) = match self.play(technique, backends) {
            Ok(played) => played,
            Err(why) => return Ok(no_mask(technique, why)),
        };
        let figure = self.figure(measure, &masks);
        let verdict = self.limits(measure).judge(figure);
        let worse = verdict != Verdict::Pass;
        let picture = worse
            .then(|| pictures::strip(self.case_truth, &masks, &self.marked))
            .transpose()?;
        Ok(Cell {
            picture,
            disagreeing,
            ..cell(technique, CellOutcome::Measured { figure, verdict })
        })
    }

    /// The mask at the first frame's receivers, frame by frame, and on how many decided pixels backends differ.
    fn play(
        &self,
        technique: &dyn ShadowTechnique,
        backends: &mut Backends,
    ) -> Result<(Vec<Vec<f32>>, Option<u64>), NoMask> {
        let (mut masks, mut disagreeing) = (Vec::new(), None);
        for (t, frame) in self.frames.iter().enumerate() {
            let is_end = t == 0 || t + 1 == self.frames.len();
            let playing = all_backends::select(&mut backends.playing, is_end);
            let played = self.play_frame(frame, technique, playing)?;
            masks.push(played.mask);
            disagreeing = all_backends::sum(disagreeing, played.disagreeing);
        }
        Ok((masks, disagreeing))
    }

    fn play_frame(
        &self,
        frame: &MotionFrame,
        technique: &dyn ShadowTechnique,
        playing: &mut [Box<dyn Backend>],
    ) -> Result<all_backends::RenderedOnAll, NoMask> {
        let view = View::new(&frame.camera, &frame.light, &self.case_truth.geometry);
        let still = View {
            camera: &self.case_truth.camera,
            ..view
        }
        .with_receivers(&self.case_truth.truth.receivers);
        let mut recipe = guard::plan(technique, &view.with_receivers(&frame.receivers))?;
        if draws_the_picture(&recipe, &frame.camera) {
            recipe = guard::plan(technique, &still)?;
        }
        all_backends::render(playing, &still, &recipe)
    }

    /// How many points count.
    pub fn points(&self) -> usize {
        self.marked.iter().filter(|m| **m).count()
    }
}

fn at(case_truth: &CaseTruth, motion: Motion, t: u32, count: u32, texel: f64) -> (Camera, Light) {
    let (camera, light) = (case_truth.camera, case_truth.lights[0]);
    let steps = f64::from(t);
    match motion {
        Motion::Still => (camera, light),
        Motion::Pan => (panned(&camera, steps * PAN_TEXELS * texel), light),
        Motion::Yaw => (yawed(&camera, steps * YAW), light),
        Motion::Widening => {
            let part = steps / f64::from(count.max(2) - 1);
            (
                with_fov(&camera, WIDENING[0] + part * (WIDENING[1] - WIDENING[0])),
                light,
            )
        }
        Motion::Sun => (camera, turned(&light, steps * TURN)),
    }
}

fn panned(camera: &Camera, by: f64) -> Camera {
    let mut out = *camera;
    let right = out.world_from_view.matrix3.x_axis.as_dvec3().normalize();
    out.world_from_view.translation =
        (out.world_from_view.translation.as_dvec3() + right * by).as_vec3a();
    out
}

fn yawed(camera: &Camera, degrees: f64) -> Camera {
    let turn = Affine3A::from_quat(Quat::from_rotation_y(degrees.to_radians() as f32));
    let mut out = *camera;
    out.world_from_view.matrix3 = turn.matrix3 * out.world_from_view.matrix3;
    out
}

fn turned(light: &Light, degrees: f64) -> Light {
    match *light {
        Light::Directional {
            direction,
            angular_diameter,
        } => {
            let turn = glam::DQuat::from_rotation_y(degrees.to_radians());
            Light::Directional {
                direction: (turn * direction.as_dvec3()).as_vec3(),
                angular_diameter,
            }
        }
        other => other,
    }
}

/// Width of a texel of the first frame's map, metres.
fn texel(case_truth: &CaseTruth) -> Result<f64, LabError> {
    let view = case_truth
        .view(&case_truth.lights[0])
        .with_receivers(&case_truth.truth.receivers);
    let spaces = Fit::Tight.light_spaces(Layout::Auto, &view, case_truth.map_size, 0.0)?;
    let across = spaces
        .spaces
        .first()
        .map_or(1.0, |s| f64::from(s.clip_from_view.x_axis.x));
    Ok(2.0 / (across * f64::from(case_truth.map_size)))
}

/// Near an edge, and seen in every frame.
fn is_marked(case_truth: &CaseTruth, frames: &[MotionFrame], i: usize) -> bool {
    case_truth.counts(i)
        && !case_truth.open[i]
        && frames.iter().all(|f| is_seen(case_truth, &f.camera, i))
}

fn is_seen(case_truth: &CaseTruth, camera: &Camera, i: usize) -> bool {
    let (p, n) = (
        case_truth.truth.receivers.position(i),
        case_truth.truth.receivers.normal(i),
    );
    let q = camera.space().clip_from_world() * p.extend(1.0);
    let inside = q.w > 0.0 && q.x.abs() < q.w && q.y.abs() < q.w;
    let to_eye: Vec3 = camera.eye() - p;
    // A thousandth of the way off the surface, so that its neighbours don't hide the point from the eye.
    let lift = n * (1e-3 * to_eye.length());
    inside
        && !case_truth.geometry.bvh().occluded(
            p + lift,
            to_eye - lift,
            case_truth.truth.receivers.triangle[i],
        )
}
