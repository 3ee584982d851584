//! Culling of casters for a layer: tests many boxes at a time against the layer's volume.

use glam::{Mat4, Vec3, Vec4};
use std::ops::Range;
use umbrage_core::{Aabb, Simd, SimdTask};

/// Relative rounding bound of the test of a box against a plane or a point. Each product and sum of
/// the test and of the box itself has a relative error of 2^-24, and there are fewer than sixteen
/// of them: this is 2^-18.
const ROUNDING: f32 = 1.0 / 262_144.0;
/// Half extent of empty boxes, which are outside of every plane.
const NOTHING: f32 = -1e30;
/// Greatest number of invisible slots that are drawn along to save a draw.
const GREATEST_GAP: u32 = 8;

/// Boxes of consecutive slots in arrays, so that they are tested many at a time.
#[derive(Clone, Copy, Debug)]
struct BoxChunk {
    centre: [[f32; CHUNK]; 3],
    /// Half extents; [`NOTHING`] for empty boxes.
    half: [[f32; CHUNK]; 3],
    /// Half extents, padded for the rounding of the test against a plane.
    padded: [[f32; CHUNK]; 3],
}

impl BoxChunk {
    const EMPTY: Self = Self {
        centre: [[0.0; CHUNK]; 3],
        half: [[NOTHING; CHUNK]; 3],
        padded: [[NOTHING; CHUNK]; 3],
    };
}

/// One box per slot. Empty boxes fill the last chunk.
#[derive(Debug, Default)]
pub(crate) struct CullingBoxes(Vec<BoxChunk>);

/// Selection of casters by whether they moved recently.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wanted<'a> {
    All,
    /// For each slot, whether the caster moved recently: selects those that did.
    Moving(&'a [bool]),
    /// Selects the casters that didn't.
    Still(&'a [bool]),
}

impl Wanted<'_> {
    fn has(self, slot: usize) -> bool {
        match self {
            Self::All => true,
            Self::Moving(moving) => moving[slot],
            Self::Still(moving) => !moving[slot],
        }
    }
}

/// The volume of a layer. A box entirely on the outer side of one of its planes is not visible
/// there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volume {
    /// The product of a plane with a homogeneous world position is not negative inside.
    planes: [Vec4; 6],
}

impl CullingBoxes {
    /// Adds empty boxes up to a number of slots.
    pub(crate) fn grow(&mut self, slots: u32) {
        let chunks = (slots as usize).div_ceil(CHUNK);
        self.0.resize(chunks.max(self.0.len()), BoxChunk::EMPTY);
    }

    pub(crate) fn set(&mut self, slot: u32, bounds: &Aabb) {
        let is_empty = bounds.is_empty();
        let centre = if is_empty {
            Vec3::ZERO
        } else {
            bounds.center()
        };
        let half = if is_empty {
            Vec3::splat(NOTHING)
        } else {
            bounds.extent() * 0.5
        };
        let padded = half + (half.abs() + centre.abs()) * ROUNDING;
        let (chunk, i) = chunk_of(slot);
        let chunk = &mut self.0[chunk];
        for axis in 0..3 {
            chunk.centre[axis][i] = centre[axis];
            chunk.half[axis][i] = half[axis];
            chunk.padded[axis][i] = padded[axis];
        }
    }

    pub(crate) fn get(&self, slot: u32) -> Aabb {
        let (chunk, i) = chunk_of(slot);
        let chunk = &self.0[chunk];
        let centre = Vec3::from(chunk.centre.each_ref().map(|values| values[i]));
        let half = Vec3::from(chunk.half.each_ref().map(|values| values[i]));
        if half.x == NOTHING {
            return Aabb::EMPTY;
        }
        Aabb {
            min: centre - half,
            max: centre + half,
        }
    }

    pub(crate) fn copy(&mut self, from: u32, to: u32) {
        let (from, i) = chunk_of(from);
        let (to, j) = chunk_of(to);
        for axis in 0..3 {
            self.0[to].centre[axis][j] = self.0[from].centre[axis][i];
            self.0[to].half[axis][j] = self.0[from].half[axis][i];
            self.0[to].padded[axis][j] = self.0[from].padded[axis][i];
        }
    }

    /// Returns the box around all boxes.
    pub(crate) fn around_all(&self) -> Aabb {
        Simd::Native.run_task(FindEnds(&self.0))
    }

    /// Returns the distance from a point to the nearest box, less its rounding; infinite without
    /// boxes.
    pub(crate) fn distance_from(&self, point: Vec3) -> f32 {
        Simd::Native
            .run_task(FindNearest {
                chunks: &self.0,
                point,
            })
            .sqrt()
    }
}

/// Returns the distance of a point from a box along an axis, less its rounding; 0 inside.
#[inline(always)]
pub(crate) fn gap(at: f32, centre: f32, half: f32) -> f32 {
    let rounding = (at.abs() + centre.abs() + half.abs()) * ROUNDING;
    let outside = (at - centre).abs() - half - rounding;
    if outside > 0.0 { outside } else { 0.0 }
}

/// Finds the least squared distance from a point to a box.
struct FindNearest<'a> {
    chunks: &'a [BoxChunk],
    point: Vec3,
}

impl SimdTask for FindNearest<'_> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let mut least = [f32::INFINITY; CHUNK];
        for chunk in self.chunks {
            let mut squares = [0.0_f32; CHUNK];
            for axis in 0..3 {
                let at = self.point[axis];
                let boxes = chunk.centre[axis].iter().zip(&chunk.half[axis]);
                for (square, (&centre, &half)) in squares.iter_mut().zip(boxes) {
                    // For empty boxes, the sum is infinite.
                    let outside = gap(at, centre, half);
                    *square += outside * outside;
                }
            }
            for (least, square) in least.iter_mut().zip(squares) {
                *least = if square < *least { square } else { *least };
            }
        }
        least.into_iter().fold(f32::INFINITY, f32::min)
    }
}

/// Finds the box around all boxes.
struct FindEnds<'a>(&'a [BoxChunk]);

impl SimdTask for FindEnds<'_> {
    type Output = Aabb;

    #[inline(always)]
    fn run(self) -> Aabb {
        let mut all = Aabb::EMPTY;
        for axis in 0..3 {
            // Use separate lanes: the minimum of several numbers is the same in any order.
            let mut min = [f32::INFINITY; CHUNK];
            let mut max = [f32::NEG_INFINITY; CHUNK];
            for chunk in self.0 {
                let boxes = chunk.centre[axis].iter().zip(&chunk.half[axis]);
                for (i, (&centre, &half)) in boxes.enumerate() {
                    // Skip empty boxes.
                    let is_empty = half < 0.0;
                    let low = if is_empty {
                        f32::INFINITY
                    } else {
                        centre - half
                    };
                    let high = if is_empty {
                        f32::NEG_INFINITY
                    } else {
                        centre + half
                    };
                    min[i] = if low < min[i] { low } else { min[i] };
                    max[i] = if high > max[i] { high } else { max[i] };
                }
            }
            all.min[axis] = min.into_iter().fold(f32::INFINITY, f32::min);
            all.max[axis] = max.into_iter().fold(f32::NEG_INFINITY, f32::max);
        }
        all
    }
}

impl Volume {
    /// Returns the volume of a layer with a side of `size` texels, including a border of one texel.
    pub(crate) fn new(clip_from_world: &Mat4, size: u32) -> Self {
        let rows = clip_from_world.transpose();
        let [x, y, z, w] = [rows.x_axis, rows.y_axis, rows.z_axis, rows.w_axis];
        // Rasterisers move corners by less than a texel; the map spans two units of clip space.
        let wide = w * (1.0 + 2.0 / size.max(1) as f32);
        // Extract the planes as in Gribb and Hartmann 2001, "Fast extraction of viewing frustum
        // planes from the world-view-projection matrix".
        Self {
            planes: [wide + x, wide - x, wide + y, wide - y, z, w - z],
        }
    }

    /// Returns whether a box may be visible in the layer.
    pub(crate) fn may_show(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let centre = bounds.center();
        let half = bounds.extent() * 0.5;
        self.planes
            .iter()
            .all(|plane| farthest_inside(plane, centre, half) >= 0.0)
    }

    /// Returns whether one of these boxes may be visible in the layer. Tests the box at the index
    /// `last` first. If another one is found, `last` becomes its index.
    pub(crate) fn may_show_any(&self, boxes: &[Aabb], last: &mut usize) -> bool {
        let may_show = |bounds: &Aabb| self.may_show(bounds);
        if boxes.get(*last).is_some_and(may_show) {
            return true;
        }
        let found = boxes.iter().position(may_show);
        *last = found.unwrap_or(*last);
        found.is_some()
    }

    /// Tests, for each slot, whether its box may be visible in the layer.
    pub(crate) fn find(&self, boxes: &CullingBoxes, shown: &mut ShownSlots) {
        shown.0.resize(CHUNK * boxes.0.len(), 0);
        Simd::Native.run_task(FindShown {
            planes: &self.planes,
            chunks: &boxes.0,
            out: &mut shown.0,
        });
    }
}

/// Tests all boxes against the planes of a volume.
struct FindShown<'a> {
    planes: &'a [Vec4; 6],
    chunks: &'a [BoxChunk],
    out: &'a mut [u32],
}

impl SimdTask for FindShown<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (out, _) = self.out.as_chunks_mut();
        for (chunk, out) in self.chunks.iter().zip(out) {
            *out = find_chunk(self.planes, chunk);
        }
    }
}

/// Returns the chunk of a slot, and its index in it.
#[inline(always)]
fn chunk_of(slot: u32) -> (usize, usize) {
    (slot as usize / CHUNK, slot as usize % CHUNK)
}

/// Returns 1 for each box that may be visible, and 0 for the others.
#[inline(always)]
fn find_chunk(planes: &[Vec4; 6], chunk: &BoxChunk) -> [u32; CHUNK] {
    let BoxChunk { centre, padded, .. } = chunk;
    let mut inside = [1_u32; CHUNK];
    for plane in planes {
        let outwards = plane.abs();
        let constant = plane.w + outwards.w * ROUNDING;
        for i in 0..CHUNK {
            let x = plane.x * centre[0][i] + outwards.x * padded[0][i];
            let y = plane.y * centre[1][i] + outwards.y * padded[1][i];
            let z = plane.z * centre[2][i] + outwards.z * padded[2][i];
            inside[i] &= u32::from(x + y + z + constant >= 0.0);
        }
    }
    inside
}

/// Number of boxes tested against a plane at a time: a few vectors of the processor.
const CHUNK: usize = 32;

/// For each slot, 1 if it may be visible in a layer, or else 0.
#[derive(Debug, Default)]
pub(crate) struct ShownSlots(Vec<u32>);

impl ShownSlots {
    /// Returns the numbers of still and of moving slots in a range that may be visible.
    pub(crate) fn count(&self, slots: Range<u32>, moving: &[bool]) -> [u64; 2] {
        let slots = slots.start as usize..slots.end as usize;
        let mut all = 0;
        let mut moved = 0;
        for (&shown, &moves) in self.0[slots.clone()].iter().zip(&moving[slots]) {
            all += shown;
            moved += shown & u32::from(moves);
        }
        [all - moved, moved].map(u64::from)
    }

    /// Appends the rising runs of wanted slots in a range that may be visible.
    pub(crate) fn runs(&self, slots: Range<u32>, wanted: Wanted<'_>, out: &mut Vec<Range<u32>>) {
        let gap = match wanted {
            Wanted::All => GREATEST_GAP,
            // Slots between two runs may not be wanted.
            Wanted::Moving(_) | Wanted::Still(_) => 0,
        };
        let first_run = out.len();
        for slot in slots {
            if self.0[slot as usize] == 0 || !wanted.has(slot as usize) {
                continue;
            }
            match out[first_run..].last_mut() {
                Some(run) if slot - run.end <= gap => run.end = slot + 1,
                _ => out.push(slot..slot + 1),
            }
        }
    }
}

/// Returns the greatest product of a plane with a point of a box, padded for rounding.
#[inline(always)]
fn farthest_inside(plane: &Vec4, centre: Vec3, half: Vec3) -> f32 {
    let x = plane.x * centre.x;
    let y = plane.y * centre.y;
    let z = plane.z * centre.z;
    let reach = plane.x.abs() * half.x + plane.y.abs() * half.y + plane.z.abs() * half.z;
    let summed = x.abs() + y.abs() + z.abs() + plane.w.abs() + reach.abs();
    x + y + z + plane.w + reach + summed * ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box(x: f32) -> Aabb {
        Aabb {
            min: Vec3::new(x, -0.5, 0.25),
            max: Vec3::new(x + 1.0, 0.5, 0.75),
        }
    }

    #[test]
    fn runs_are_the_boxes_that_may_show() {
        let mut boxes = CullingBoxes::default();
        boxes.grow(100);
        for slot in 0..100_u32 {
            // Every third slot is empty.
            let bounds = if slot.is_multiple_of(3) {
                Aabb::EMPTY
            } else {
                unit_box(slot as f32)
            };
            boxes.set(slot, &bounds);
            assert_eq!(boxes.get(slot), bounds);
        }
        // The clip volume is x in -40..=40, shifted to 10..=90.
        let clip_from_world = Mat4::from_scale(Vec3::new(1.0 / 40.0, 1.0, 1.0))
            * Mat4::from_translation(Vec3::new(-50.0, 0.0, 0.0));
        let volume = Volume::new(&clip_from_world, 80);
        let mut found = ShownSlots::default();
        volume.find(&boxes, &mut found);
        let mut runs = Vec::new();
        found.runs(0..100, Wanted::All, &mut runs);
        let moving: Vec<bool> = (0..100).map(|slot| slot % 2 == 0).collect();
        let mut apart = Vec::new();
        found.runs(0..100, Wanted::Moving(&moving), &mut apart);
        assert!(apart.iter().all(|run| run.len() == 1 && run.start % 2 == 0));
        let odd = apart.len();
        found.runs(0..100, Wanted::Still(&moving), &mut apart);
        let counted = found.count(0..100, &moving);
        assert_eq!(counted, [apart.len() - odd, odd].map(|count| count as u64));
        assert!(odd > 10 && apart.len() > odd + 10, "{apart:?}");
        let shown = |slot: u32| runs.iter().any(|run| run.contains(&slot));
        for slot in 0..100 {
            if volume.may_show(&boxes.get(slot)) {
                assert!(shown(slot), "{slot} may show and is in no run");
            }
        }
        assert!(
            shown(10) && shown(89) && !shown(5) && !shown(95),
            "{runs:?}"
        );
        let around = boxes.around_all();
        assert_eq!((around.min.x, around.max.x), (1.0, 99.0 + 1.0 - 1.0));
    }

    #[test]
    fn any_box_is_found_from_any_index() {
        let volume = Volume::new(&Mat4::IDENTITY, 100);
        let [inside, outside] = [unit_box(0.0), unit_box(7.0)];
        for first in 0..4 {
            let mut last = first;
            assert!(!volume.may_show_any(&[outside; 3], &mut last));
            assert!(!volume.may_show_any(&[], &mut last));
            assert_eq!(last, first);
            assert!(volume.may_show_any(&[outside, inside, outside], &mut last));
            assert_eq!(last, 1);
            assert!(volume.may_show_any(&[inside, inside], &mut last));
            assert_eq!(last, 1);
        }
    }

    #[test]
    fn the_near_and_far_planes_bound_a_layer() {
        let volume = Volume::new(&Mat4::IDENTITY, 100);
        let at = |z: f32| Aabb {
            min: Vec3::new(0.0, 0.0, z),
            max: Vec3::new(0.1, 0.1, z + 0.1),
        };
        assert!(volume.may_show(&at(0.5)) && volume.may_show(&at(-0.05)));
        assert!(!volume.may_show(&at(-0.2)) && !volume.may_show(&at(1.1)));
        assert!(!volume.may_show(&Aabb::EMPTY));
    }
}
