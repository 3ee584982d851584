//! CPU method for all receivers of an image without lists: casters are tested against receivers.
//!
//! This is the transpose of [`lookup`](super::lookup), after Johnson, Lee, Burns and Mark 2005,
//! "The Irregular Z-Buffer". The hierarchy over receivers is that of Sintorn, Kämpe, Olsson and
//! Assarsson 2014, "Per-Triangle Shadow Volumes Using a View-Sample Cluster Hierarchy". Each run of
//! casters traverses boxes around receivers as projected to the light. It keeps those of its
//! casters that may hide the light there. The triangle test then finds the blocked receivers. Boxes
//! are widened by the margins of [`light_frame`](super::light_frame), so no hit is lost, and any
//! hit blocks the light. So the result equals that of `traced`, for any order of casters and any
//! number of threads.

mod boxes;
mod caster_run;
mod open;
mod order;
mod rays;

use super::{
    holes::CasterHoles,
    light_frame::{ExactUniforms, LightFrame},
};
use boxes::{BOXES, Reach};
use caster_run::{CasterRun, RUN};
use open::take_lowest;
use rays::{AllRays, FaceRays, Rays, make_rays};
use std::ops::Range;
use umbrage_core::parallel::prelude::*;
use umbrage_core::{Aabb, Geometry, Receivers, Simd, SimdTask};

/// Number of runs of casters per task of a thread.
const RUNS_A_TASK: usize = 16;

/// Greatest number of casters that are tested one by one with eight boxes at a time. More are
/// tested together, with one box after the other.
const MANY: u32 = 16;

/// Capacity of the stack of nodes: seven per level and one more. There are at most eleven levels
/// for 2^32 pixels.
const MOST_WAITING: usize = 80;

/// Returns the light's visibility for each receiver; 1 for pixels without one.
pub(super) fn answer_all(
    simd: Simd,
    uniforms: &ExactUniforms,
    frame: &LightFrame,
    geometry: &Geometry,
    holes: Option<CasterHoles<'_>>,
    receivers: &Receivers,
) -> Vec<f32> {
    let AllRays { faces, mask } = make_rays(simd, uniforms, frame, receivers);
    let hide = Hide {
        frame,
        geometry,
        holes,
        faces: &faces,
        rays: Rays::from_uniforms(uniforms, frame),
    };
    let casters = geometry.casters();
    let runs = casters.start as usize / RUN..(casters.end as usize).div_ceil(RUN);
    let tasks = geometry.run_boxes()[runs.clone()].par_chunks(RUNS_A_TASK);
    tasks.enumerate().for_each(|(task, boxes)| {
        simd.run_task(HideFromRuns {
            hide: &hide,
            first_run: runs.start + task * RUNS_A_TASK,
            boxes,
        });
    });
    for face in &faces {
        face.answer(&mask);
    }
    mask.into_numbers()
}

/// Data for blocking receivers.
struct Hide<'a> {
    frame: &'a LightFrame,
    geometry: &'a Geometry,
    /// Alpha test of the casters; `None` if none is alpha-tested.
    holes: Option<CasterHoles<'a>>,
    faces: &'a [FaceRays],
    rays: Rays,
}

/// Task that blocks receivers with some runs of casters.
struct HideFromRuns<'a> {
    hide: &'a Hide<'a>,
    first_run: usize,
    /// Bounds of each run.
    boxes: &'a [Aabb],
}

impl SimdTask for HideFromRuns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let all = self.hide.geometry.casters();
        let mut casters = CasterRun::new();
        for (i, bounds) in self.boxes.iter().enumerate() {
            let first = ((self.first_run + i) * RUN) as u32;
            let run = first.max(all.start)..(first + RUN as u32).min(all.end);
            for face in self.hide.faces {
                self.hide.hide_from_run(face, &run, bounds, &mut casters);
            }
        }
    }
}

/// Eight boxes to visit, with a bit for each caster of a run that may hide the light there.
#[derive(Clone, Copy, Default)]
struct Visit {
    level: usize,
    number: usize,
    casters: u64,
}

impl Hide<'_> {
    /// Blocks receivers on a face with a run of casters. `casters` is scratch memory.
    #[inline(always)]
    fn hide_from_run(
        &self,
        face: &FaceRays,
        run: &Range<u32>,
        bounds: &Aabb,
        casters: &mut CasterRun,
    ) {
        // Reject runs outside the face or in blocked parts.
        let Some(reach) = Reach::of_box(self.frame, face.face, bounds) else {
            return;
        };
        let top = face.levels.len() - 1;
        if face.levels[top][0].met_by(&reach) & face.open.parts(top, 0) == 0 {
            return;
        }
        // Traverse the boxes from the top.
        casters.read(self.frame, self.geometry, face.face, run);
        let mut waiting = [Visit::default(); MOST_WAITING];
        waiting[0] = Visit {
            level: top,
            number: 0,
            casters: casters.all(),
        };
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let visit = waiting[count];
            if visit.level == 0 {
                self.hide_in_blocks(face, casters, visit);
                continue;
            }
            let of_child = self.casters_of_children(face, casters, visit);
            for (child, &casters) in of_child.iter().enumerate() {
                waiting[count] = Visit {
                    level: visit.level - 1,
                    number: visit.number * BOXES + child,
                    casters,
                };
                count += usize::from(casters != 0);
            }
        }
    }

    /// Returns, for each of eight boxes, a bit for each caster that may hide the light there.
    #[inline(always)]
    fn casters_of_children(
        &self,
        face: &FaceRays,
        casters: &mut CasterRun,
        visit: Visit,
    ) -> [u64; BOXES] {
        let boxes = &face.levels[visit.level][visit.number];
        let mut open = face.open.parts(visit.level, visit.number);
        let mut out = [0; BOXES];
        if visit.casters.count_ones() > MANY {
            let mut children = boxes.met_by(&casters.reach) & open;
            while let Some(child) = take_lowest(&mut children) {
                out[child] = visit.casters & casters.meeting_bits(&boxes.get(child));
            }
            return out;
        }
        let mut left = visit.casters;
        while left != 0 {
            let caster = left.trailing_zeros();
            left &= left - 1;
            let by_outline = casters.meets(self.frame, caster as usize, boxes);
            let covered = by_outline.covered & open;
            if covered != 0 {
                open &= !covered;
                face.open.close_parts(visit.level, visit.number, covered);
            }
            let mut children = by_outline.met & open;
            while let Some(child) = take_lowest(&mut children) {
                out[child] |= 1 << caster;
            }
        }
        out
    }

    /// Blocks receivers in eight blocks with casters.
    #[inline(always)]
    fn hide_in_blocks(&self, face: &FaceRays, casters: &mut CasterRun, visit: Visit) {
        let boxes = &face.levels[0][visit.number];
        let mut left = visit.casters;
        while left != 0 {
            let caster = left.trailing_zeros() as usize;
            left &= left - 1;
            let by_outline = casters.meets(self.frame, caster, boxes);
            let open = face.open.parts(0, visit.number);
            let covered = by_outline.covered & open;
            if covered != 0 {
                face.open.close_parts(0, visit.number, covered);
            }
            let reach = casters.reach_of(caster);
            let id = casters.id(caster);
            let mut blocks = by_outline.met & open & !covered;
            while let Some(block) = take_lowest(&mut blocks) {
                let block = visit.number * BOXES + block;
                let corners = || casters.corners(caster);
                let holes = self.holes.filter(|_| casters.has_holes(caster));
                face.hide(block, &self.rays, &reach, id, corners, holes);
            }
        }
    }
}
