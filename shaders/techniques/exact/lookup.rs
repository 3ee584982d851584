//! The CPU half of the kernel: rays are placed on the grid in vector lanes, lists are walked one receiver at a time.

use super::{
    ExactUniforms,
    light_frame::LightFrame,
    lists::Lists,
    outline::Outline,
    touches::DEPTH_UNKNOWN,
};
use crate::lanes::batch::{BATCH, Lanes, PaddedReceivers, ReceiverBatch};
use umbrage_core::{
    Simd, SimdTask, Span,
    bvh::segment_hits,
    glam::{Vec2, Vec3, Vec4},
    light_sample::{origin_offset, segment},
    math::dot3,
};

/// Fills `out`, as long as the span, with the light's visibility.
pub(super) fn look_up_span(
    simd: Simd,
    uniforms: &ExactUniforms,
    lists: &Lists,
    span: &Span<'_>,
    out: &mut [f32],
) {
    let mut rays = Rays::new();
    let mut padded = PaddedReceivers::new();
    let mut walk = Walk {
        lists,
        per_margin: uniforms.origin.w,
        last_hit: NO_CASTER,
    };
    for first in (0..out.len()).step_by(BATCH) {
        let count = BATCH.min(out.len() - first);
        let receivers = ReceiverBatch::from(span, first, &mut padded);
        let frame = &lists.frame;
        if frame.is_lamp {
            simd.run_task(Place::<true> {
                uniforms,
                frame,
                receivers: &receivers,
                out: &mut rays,
            });
        } else {
            simd.run_task(Place::<false> {
                uniforms,
                frame,
                receivers: &receivers,
                out: &mut rays,
            });
        }
        simd.run_task(Answer {
            walk: &mut walk,
            rays: &rays,
            own: &span.triangle[first..first + count],
            out: &mut out[first..first + count],
        });
    }
}

/// The number of no caster.
const NO_CASTER: u32 = u32::MAX;

/// The rays of a batch of receivers, and where they fall on the grid.
struct Rays {
    origin: [Lanes<f32>; 3],
    vector: [Lanes<f32>; 3],
    direction: [Lanes<f32>; 3],
    depth: Lanes<f32>,
    /// Across and down the face, tiles.
    at: [Lanes<f32>; 2],
    /// Negative where the light lies below the receiver's tangent plane.
    face: Lanes<i32>,
}

/// [`Rays::face`] of receivers that face away from the light.
const FACES_AWAY: i32 = -1;

impl Rays {
    fn new() -> Self {
        let zeros = [0.0; BATCH];
        Self {
            origin: [zeros; 3],
            vector: [zeros; 3],
            direction: [zeros; 3],
            depth: zeros,
            at: [zeros; 2],
            face: [0; BATCH],
        }
    }

    #[inline(always)]
    fn at(lanes: &[Lanes<f32>; 3], i: usize) -> Vec3 {
        Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i])
    }
}

/// Places a batch of receivers.
struct Place<'a, const LAMP: bool> {
    uniforms: &'a ExactUniforms,
    frame: &'a LightFrame,
    receivers: &'a ReceiverBatch<'a>,
    out: &'a mut Rays,
}

impl<const LAMP: bool> SimdTask for Place<'_, LAMP> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let u = self.uniforms;
        let frame = *self.frame;
        let eye = u.eye.truncate();
        let receivers = *self.receivers;
        let sun = segment(&u.light, Vec3::ZERO, Vec2::ZERO, u.far);
        for i in 0..BATCH {
            let p = receivers.position(i);
            let n = receivers.normal(i);
            let to_eye = (eye - p).abs();
            let reach = to_eye.x.max(to_eye.y).max(to_eye.z).max(u.grid.w);
            let o = p + n * origin_offset(p, reach);
            let d = if LAMP {
                // As `segment` has it of a point.
                (u.light.center.truncate() - o) * umbrage_core::light_sample::SHORT
            } else {
                sun
            };
            let faces_away = dot3(n, d) <= 0.0;
            let v = frame.place_as::<LAMP>(o);
            let point = frame.look_up_as::<LAMP>(v);
            let at = (point.on_face + frame.half) * frame.tiles_a_unit;
            let out = &mut *self.out;
            out.origin[0][i] = o.x;
            out.origin[1][i] = o.y;
            out.origin[2][i] = o.z;
            out.vector[0][i] = d.x;
            out.vector[1][i] = d.y;
            out.vector[2][i] = d.z;
            out.direction[0][i] = point.direction.x;
            out.direction[1][i] = point.direction.y;
            out.direction[2][i] = point.direction.z;
            out.depth[i] = point.depth;
            out.at[0][i] = at.x;
            out.at[1][i] = at.y;
            out.face[i] = if faces_away { FACES_AWAY } else { point.face as i32 };
        }
    }
}

/// Answers for a batch.
struct Answer<'a, 'b> {
    walk: &'a mut Walk<'b>,
    rays: &'a Rays,
    own: &'a [u32],
    out: &'a mut [f32],
}

impl SimdTask for Answer<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (i, (out, &own)) in self.out.iter_mut().zip(self.own).enumerate() {
            let is_lit = self.rays.face[i] != FACES_AWAY && !self.walk.is_shadowed(self.rays, i, own);
            *out = if is_lit { 1.0 } else { 0.0 };
        }
    }
}

/// Walks lists.
struct Walk<'a> {
    lists: &'a Lists,
    per_margin: f32,
    /// The caster that hid the light from the last receiver: it mostly hides it from the next, too, and any hit will do.
    last_hit: u32,
}

impl Walk<'_> {
    /// Returns whether the ray of lane `i` meets a caster other than triangle `own`.
    #[inline(always)]
    fn is_shadowed(&mut self, rays: &Rays, i: usize, own: u32) -> bool {
        let lists = self.lists;
        let frame = &lists.frame;
        let depth = rays.depth[i];
        let terms = frame.depth_terms(depth, self.per_margin);
        let direction = Rays::at(&rays.direction, i);
        if self.last_hit != NO_CASTER
            && self.last_hit & !DEPTH_UNKNOWN != own
            && self.verdict(self.last_hit, direction, terms) == Verdict::Hit
        {
            return true;
        }
        let at = Vec2::new(rays.at[0][i], rays.at[1][i]);
        let [wide, high] = [frame.tiles.x as f32, frame.tiles.y as f32];
        // Written so that what is not a number is outside. A lamp's faces end where others begin.
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < wide && at.y < high;
        if !is_inside && !frame.is_lamp {
            self.last_hit = NO_CASTER;
            return false;
        }
        let at = at.clamp(Vec2::ZERO, Vec2::new(wide, high) - 0.001);
        let x = at.x as i32;
        let y = at.y as i32;
        let face = rays.face[i] as usize;
        let tile = (face * frame.tiles.y as usize + y as usize) * frame.tiles.x as usize + x as usize;
        let [first_cell, side_log2] = pair_at(&lists.tiles, tile);
        let side = (1_u32 << side_log2) as f32;
        let cell_x = ((at.x - x as f32) * side) as i32 as u32;
        let cell_y = ((at.y - y as f32) * side) as i32 as u32;
        let cell = first_cell + (cell_y << side_log2) + cell_x;
        let [first, count, covered_behind, _] = lists.cells[cell as usize];
        if depth > f32::from_bits(covered_behind) {
            return true;
        }
        for k in first..first + count {
            let [word, nearest] = pair_at(&lists.items, k as usize);
            if f32::from_bits(nearest) > depth {
                break;
            }
            if word & !DEPTH_UNKNOWN == own {
                continue;
            }
            let is_hit = match self.verdict(word, direction, terms) {
                Verdict::Miss => false,
                Verdict::Hit => true,
                Verdict::Unsure => self.meets(rays, i, word & !DEPTH_UNKNOWN),
            };
            if is_hit {
                self.last_hit = word;
                return true;
            }
        }
        self.last_hit = NO_CASTER;
        false
    }

    /// What a caster's outline says; `word` is as in a list.
    #[inline(always)]
    fn verdict(&self, word: u32, direction: Vec3, [factor, summand]: [Vec4; 2]) -> Verdict {
        let caster = word & !DEPTH_UNKNOWN;
        let outline = Outline::of_caster(&self.lists.outlines, caster);
        let mut value = outline.at(direction) * factor + summand;
        if word != caster {
            value.w = 0.0;
        }
        if value.cmplt(Vec4::NEG_ONE).any() {
            Verdict::Miss
        } else if value.cmpgt(Vec4::ONE).all() {
            Verdict::Hit
        } else {
            Verdict::Unsure
        }
    }

    /// The triangle test of rays.
    #[inline(never)]
    fn meets(&self, rays: &Rays, i: usize, caster: u32) -> bool {
        let first = 3 * caster as usize;
        let rows = &self.lists.corners[first..first + 3];
        let corner = |i: usize| {
            let row = rows[i].map(f32::from_bits);
            Vec3::new(row[0], row[1], row[2])
        };
        let o = Rays::at(&rays.origin, i);
        let d = Rays::at(&rays.vector, i);
        segment_hits(o, d, corner(0), corner(1), corner(2))
    }
}

/// Whether a ray meets a caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Hit,
    Miss,
    /// The triangle test decides.
    Unsure,
}

/// Returns entry `i` of a table with two a row.
#[inline(always)]
fn pair_at(rows: &[[u32; 4]], i: usize) -> [u32; 2] {
    let row = &rows[i / 2];
    let place = 2 * (i % 2);
    [row[place], row[place + 1]]
}
