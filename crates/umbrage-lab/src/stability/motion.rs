//! Moving cases: what changes from frame to frame at points that stay.
//!
//! The points are the receivers of the first frame's pixels that are near edges of shadows and seen in all frames. For each
//! frame a technique's map is fitted to that frame's camera and drawn anew, and looked up at these same points. Techniques
//! that cast into the camera's own picture (planar shadows, volumes) have visibilities only at that camera's pixels: they are
//! always played with the first camera, so that their change while the camera moves alone is *not measured*. Neither is that
//! of techniques without a map (rays) whose answer at a point never changes: it has no way to follow the camera.
//!
//! While the camera moves, its pictures show the points at other pixels: a point that is asked at pixel (x, y) in the first
//! frame is asked at (x + 1, y) in the second, and so on. So patterns and noise that follow the pixel (dithered or turned taps,
//! random rays) change at a point, as they do on a screen.
//!
//! Figures are the first backend's. The others play the first and the last frame, the two that differ most, and must agree
//! there.

use super::{
    Cell, CellOutcome, Criterion, Judgement, Verdict, VerdictLimits, all_backends,
    case_truth::{CaseTruth, visibility_at_receivers},
    guard::{self, NoMask},
    measure::Measure,
    measures::shimmer::{change, change_error, shimmer},
    pictures,
    play::{cell, no_mask},
    row::Motion,
};
use crate::{LabError, compare::Backends};
use glam::{Affine3A, Quat, Vec2, Vec3};
use umbrage_core::{
    Backend, Camera, Fit, Geometry, Invalid, Layout, Light, Receivers, ShadowTechnique, View,
};
use umbrage_cpu::Cpu;
use umbrage_plan::{
    motion::{draws_the_picture, pixel_shift},
    truth::TruthOptions,
};

/// The camera, the light and the casters of one frame.
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

/// A moving case, ready to be played.
#[derive(Clone, Debug)]
pub struct Moving<'a> {
    /// Truth about its first frame.
    pub case_truth: &'a CaseTruth,
    /// All frames, the first among them.
    pub frames: Vec<MotionFrame>,
    /// True visibility at the first frame's receivers, frame by frame.
    pub truth: Vec<Vec<f32>>,
    /// Which of the first frame's receivers count.
    pub marked: Vec<bool>,
    /// What moves.
    pub motion: Motion,
}

/// Texels that the camera pans by from a frame to the next.
const PAN_TEXELS: f64 = 0.37;
/// Texels that casters move by from a frame to the next: more than one, so that no frame may rest, and no whole number.
const CASTER_TEXELS: f64 = 1.37;
/// Degrees that the camera yaws by from a frame to the next.
const YAW: f64 = 0.1;
/// Degrees that the sun turns by from a frame to the next.
const TURN: f64 = 0.25;
/// Vertical field of view of the first frame of a widening, degrees.
const FIRST_FOV: f64 = 75.0;
/// Vertical field of view of the last frame of a widening, degrees.
const LAST_FOV: f64 = 90.0;

/// Returns the camera that a motion starts from.
pub(super) fn first_camera(camera: &Camera, motion: Motion) -> Camera {
    if motion == Motion::Widening {
        with_fov(camera, FIRST_FOV)
    } else {
        *camera
    }
}

/// Returns the camera with another vertical field of view, degrees, and the same aspect ratio.
fn with_fov(camera: &Camera, degrees: f64) -> Camera {
    let mut out = *camera;
    // A perspective matrix scales y by the cotangent of half the angle.
    let scale = (1.0 / (0.5 * degrees.to_radians()).tan()) as f32;
    out.clip_from_view.x_axis.x *= scale / out.clip_from_view.y_axis.y;
    out.clip_from_view.y_axis.y = scale;
    out
}

impl<'a> Moving<'a> {
    /// Moves the case's camera or light through `count` frames, and traces truth.
    ///
    /// # Errors
    /// Errors if the scene holds numbers that can't be used.
    pub fn new(
        case_truth: &'a CaseTruth,
        motion: Motion,
        count: u32,
        options: &TruthOptions,
    ) -> Result<Self, LabError> {
        let mut cpu = Cpu::new();
        let texel = texel_width(case_truth)?;
        let mut frames = Vec::new();
        let mut truth = Vec::new();
        for index in 0..count {
            let camera = camera_at(case_truth, motion, index, count, texel);
            let light = light_at(case_truth, motion, index);
            let geometry = geometry_at(case_truth, motion, index, texel)?;
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
        let marked = (0..case_truth.open.len())
            .map(|i| is_marked(case_truth, &frames, i))
            .collect();
        Ok(Self {
            case_truth,
            frames,
            truth,
            marked,
            motion,
        })
    }

    /// Returns a measure's figure of the masks, one for each frame, at the first frame's receivers: how much they change though
    /// they should not; for measures of a single mask, that of the first frame.
    pub fn figure(&self, measure: Measure, masks: &[Vec<f32>]) -> f64 {
        let width = self.case_truth.truth.size.x as usize;
        match measure {
            Measure::ChangeError => change_error(masks, &self.truth, &self.marked, width),
            Measure::Shimmer => shimmer(masks, &self.truth, &self.marked),
            of_one_mask => of_one_mask.figure(self.case_truth, &masks[0]),
        }
    }

    /// Returns where that figure passes and fails; `limits` are the measure's own ([`Measure::limits`]). Where truth moves, a
    /// shadow that stands still fails, however slow the movement: its figure is truth's own change.
    pub fn limits(&self, measure: Measure, limits: VerdictLimits) -> VerdictLimits {
        match measure {
            Measure::ChangeError => limits.below(change(&self.truth, &self.marked)),
            _ => limits,
        }
    }

    /// Plays one setting and returns its cell.
    pub(super) fn cell(
        &self,
        technique: &dyn ShadowTechnique,
        criteria: &[Criterion],
        backends: &mut Backends,
    ) -> Result<Cell, LabError> {
        let played = match self.play(technique, backends) {
            Ok(played) => played,
            Err(why) => return Ok(no_mask(technique, why)),
        };
        let mut judgements = Vec::new();
        for criterion in criteria {
            let figure = self.figure(criterion.measure, &played.masks);
            let cannot_change = match criterion.measure {
                Measure::Shimmer => played.cannot_change(figure),
                _ => None,
            };
            judgements.push(match cannot_change {
                Some(reason) => Judgement::not_measured(reason),
                None => criterion.limits.judgement(figure),
            });
        }
        let mut out = cell(technique, CellOutcome::of(judgements));
        out.disagreeing = played.disagreeing;
        if out.verdict() > Some(Verdict::NotMeasured) {
            let strip = pictures::strip(self.case_truth, &played.masks, &self.marked)?;
            out.picture = Some(strip);
        }
        Ok(out)
    }

    /// Plays all frames.
    fn play(
        &self,
        technique: &dyn ShadowTechnique,
        backends: &mut Backends,
    ) -> Result<PlayedFrames, NoMask> {
        let mut out = PlayedFrames {
            masks: Vec::new(),
            draws_the_picture: false,
            casts: false,
            disagreeing: None,
        };
        for index in 0..self.frames.len() {
            let is_end = index == 0 || index + 1 == self.frames.len();
            let playing = all_backends::select(&mut backends.playing, is_end);
            let played = self.play_frame(index, technique, playing)?;
            out.masks.push(played.rendered.mask);
            out.draws_the_picture |= played.draws_the_picture;
            out.casts |= played.casts;
            out.disagreeing = all_backends::sum(out.disagreeing, played.rendered.disagreeing);
        }
        Ok(out)
    }

    /// Renders the mask of frame `index` at the first frame's receivers.
    fn play_frame(
        &self,
        index: usize,
        technique: &dyn ShadowTechnique,
        playing: &mut [Box<dyn Backend>],
    ) -> Result<PlayedFrame, NoMask> {
        let frame = &self.frames[index];
        let geometry = &frame.geometry;
        let frame_view = View::new(&frame.camera, &frame.light, geometry);
        let first_view = View::new(&self.case_truth.camera, &frame.light, geometry);
        let at_frame = frame_view.with_receivers(&frame.receivers);
        // The map is fitted to what the frame's camera sees; the points are the first frame's.
        let recipe = guard::plan(technique, &at_frame)?;
        let casts = !recipe.casts.is_empty();
        let receivers = &self.case_truth.truth.receivers;
        // Images that are drawn as the frame's camera sees them can't be read at the first camera's pixels.
        if draws_the_picture(&recipe, &frame.camera) {
            let at_first = first_view.with_receivers(receivers);
            let recipe = guard::plan(technique, &at_first)?;
            return Ok(PlayedFrame {
                rendered: all_backends::render(playing, &at_first, &recipe)?,
                draws_the_picture: true,
                casts,
            });
        }
        let pixels = if self.motion.moves_pixels() { index } else { 0 };
        let asked_beside = pixel_shift::to_the_right(receivers, pixels);
        let at_pixels = first_view.with_receivers(&asked_beside);
        let mut rendered = all_backends::render(playing, &at_pixels, &recipe)?;
        pixel_shift::back(&mut rendered.mask, receivers.size.x, pixels);
        Ok(PlayedFrame {
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

/// What a setting gives in one frame.
struct PlayedFrame {
    /// The mask at the first frame's receivers.
    rendered: all_backends::RenderedOnAll,
    /// Whether it casts into the camera's own picture.
    draws_the_picture: bool,
    /// Whether it draws anything.
    casts: bool,
}

/// Why a technique that casts into the camera's own picture isn't measured while the camera alone moves.
const IN_THE_PICTURE: &str = "it draws into the camera's own picture, and so is asked by the first frame's camera in every frame";
/// Why a technique without a map isn't measured then.
const NO_MAP: &str = "it draws no map, and its answer at a point has no way to follow the camera while the light stands still";

impl PlayedFrames {
    /// Returns why the change of visibility, `figure`, could not have been anything but 0 while the camera alone moves; none
    /// if it could.
    fn cannot_change(&self, figure: f64) -> Option<&'static str> {
        match (self.draws_the_picture, self.casts) {
            (true, _) => Some(IN_THE_PICTURE),
            (false, false) if figure == 0.0 => Some(NO_MAP),
            _ => None,
        }
    }
}

/// What a setting gives over all frames.
struct PlayedFrames {
    /// The first backend's mask of each frame, at the first frame's receivers.
    masks: Vec<Vec<f32>>,
    /// Whether it casts into the camera's own picture.
    draws_the_picture: bool,
    /// Whether it draws anything.
    casts: bool,
    /// On how many decided pixels backends differ, all frames together; none if no other backend serves the technique.
    disagreeing: Option<u64>,
}

/// Returns the camera of frame `index` of `count`; `texel` is the width of the first map's texels, metres.
fn camera_at(case_truth: &CaseTruth, motion: Motion, index: u32, count: u32, texel: f64) -> Camera {
    let first = &case_truth.camera;
    let steps = f64::from(index);
    match motion {
        Motion::Still | Motion::Sun | Motion::Casters => *first,
        Motion::Jitter => first.nudged(jitter(index)),
        Motion::Pan => panned(first, steps * PAN_TEXELS * texel),
        Motion::Yaw => yawed(first, steps * YAW),
        Motion::Widening => {
            // 0 at the first frame, 1 at the last.
            let part = steps / f64::from(count.max(2) - 1);
            with_fov(first, FIRST_FOV + part * (LAST_FOV - FIRST_FOV))
        }
    }
}

/// Returns the light of frame `index`.
fn light_at(case_truth: &CaseTruth, motion: Motion, index: u32) -> Light {
    let first = case_truth.lights[0];
    if motion == Motion::Sun {
        turned(&first, f64::from(index) * TURN)
    } else {
        first
    }
}

/// Returns the jitter of frame `index`, pixels, -.5 to .5 each way: the sequence of Halton (1960) in bases 2 and 3, which
/// temporal antialiasing commonly takes. The first frame has none.
fn jitter(index: u32) -> Vec2 {
    if index == 0 {
        return Vec2::ZERO;
    }
    Vec2::new(
        radical_inverse(index, 2) - 0.5,
        radical_inverse(index, 3) - 0.5,
    )
}

/// Returns the digits of a number in a base, mirrored at the point: 6 is 110 in base 2, and becomes .011, which is .375.
fn radical_inverse(number: u32, base: u32) -> f32 {
    let mut rest = number;
    let mut place = 1.0_f32;
    let mut out = 0.0;
    while rest > 0 {
        place /= base as f32;
        out += (rest % base) as f32 * place;
        rest /= base;
    }
    out
}

/// Returns the triangles of frame `index`; `texel` is the width of the first map's texels, metres.
fn geometry_at(
    case_truth: &CaseTruth,
    motion: Motion,
    index: u32,
    texel: f64,
) -> Result<Geometry, Invalid> {
    if motion != Motion::Casters {
        return Ok(case_truth.geometry.clone());
    }
    let offset = f64::from(index) * CASTER_TEXELS * texel;
    let mut scene = case_truth.scene.clone();
    // The first thing is the ground.
    for instance in scene.instances.iter_mut().skip(1).filter(|i| i.casts) {
        instance.world_from_local.translation.x += offset as f32;
    }
    Geometry::bake(&scene)
}

/// Returns the camera moved to its right by this many metres.
fn panned(camera: &Camera, by: f64) -> Camera {
    let mut out = *camera;
    let right = out.world_from_view.matrix3.x_axis.as_dvec3().normalize();
    out.world_from_view.translation =
        (out.world_from_view.translation.as_dvec3() + right * by).as_vec3a();
    out
}

/// Returns the camera turned about the vertical.
fn yawed(camera: &Camera, degrees: f64) -> Camera {
    let turn = Affine3A::from_quat(Quat::from_rotation_y(degrees.to_radians() as f32));
    let mut out = *camera;
    out.world_from_view.matrix3 = turn.matrix3 * out.world_from_view.matrix3;
    out
}

/// Returns a directional light turned about the vertical; other lights stay.
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

/// Returns the width of a texel of the first frame's map, metres.
fn texel_width(case_truth: &CaseTruth) -> Result<f64, LabError> {
    let view = case_truth
        .view(&case_truth.lights[0])
        .with_receivers(&case_truth.truth.receivers);
    let spaces = Fit::Tight.light_spaces(Layout::Auto, &view, case_truth.map_size, 0.0)?;
    // Clip units, of which a map is 2 wide, for each metre.
    let scale = spaces
        .spaces
        .first()
        .map_or(1.0, |space| f64::from(space.clip_from_view.x_axis.x));
    Ok(2.0 / (scale * f64::from(case_truth.map_size)))
}

/// Whether a point counts: it is near an edge of a shadow, and seen in every frame.
fn is_marked(case_truth: &CaseTruth, frames: &[MotionFrame], i: usize) -> bool {
    case_truth.counts(i)
        && !case_truth.open[i]
        && frames
            .iter()
            .all(|frame| stands_still(case_truth, frame, i) && is_seen(case_truth, frame, i))
}

/// Whether what pixel `i` of the first frame shows has not moved in another.
fn stands_still(case_truth: &CaseTruth, frame: &MotionFrame, i: usize) -> bool {
    let triangle = case_truth.truth.receivers.triangle[i];
    frame.geometry.corners(triangle) == case_truth.geometry.corners(triangle)
}

/// Whether a frame's camera sees the point at pixel `i` of the first frame.
fn is_seen(case_truth: &CaseTruth, frame: &MotionFrame, i: usize) -> bool {
    let camera = &frame.camera;
    let receivers = &case_truth.truth.receivers;
    let position = receivers.position(i);
    let clip = camera.space().clip_from_world() * position.extend(1.0);
    let is_inside = clip.w > 0.0 && clip.x.abs() < clip.w && clip.y.abs() < clip.w;
    let to_eye: Vec3 = camera.eye() - position;
    // The ray starts a thousandth of its length off the surface, so that neighboring triangles don't hide the point.
    let lift = receivers.normal(i) * (1e-3 * to_eye.length());
    let origin = position + lift;
    let direction = to_eye - lift;
    let bvh = frame.geometry.bvh();
    is_inside && !bvh.occluded(origin, direction, receivers.triangle[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_is_haltons() {
        let expected = [
            Vec2::ZERO,
            Vec2::new(0.5, 1.0 / 3.0) - 0.5,
            Vec2::new(0.25, 2.0 / 3.0) - 0.5,
            Vec2::new(0.75, 1.0 / 9.0) - 0.5,
        ];
        for (index, place) in (0..4).zip(expected) {
            assert!(jitter(index).distance(place) < 1e-6, "{index}");
        }
        assert_eq!(radical_inverse(6, 2), 0.375);
    }
}
