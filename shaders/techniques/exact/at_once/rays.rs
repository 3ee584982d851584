//! Rays of all receivers in an order that follows their projection to the light, and boxes around
//! them, level by level.
//!
//! Rays are sorted along a space-filling curve over the light's frame, which covers a square
//! completely before it leaves it (Morton 1966, "A Computer Oriented Geodetic Data Base and a New
//! Technique in File Sequencing"). So eight consecutive rays are close together, as are eight
//! consecutive blocks, and so on. A box has the same number of rays whether many pixels show little
//! of the scene or few show much.

use super::{
    super::{
        holes::CasterHoles,
        light_frame::{ExactUniforms, FramePoint, LightFrame},
    },
    boxes::{BOXES, Boxes, FaceBox, Reach},
    open::{Open, take_lowest},
    order::{Entry, KEY_BITS, Sorted, sort},
};
use crate::lanes::batch::{BATCH, PaddedReceivers, ReceiverBatch};
use std::{
    ops::Range,
    sync::atomic::{AtomicU32, Ordering},
};
use umbrage_core::parallel::prelude::*;
use umbrage_core::{
    Receivers, Simd, SimdTask,
    bvh::{FourSegments, SEGMENT_LANES, longest_axis},
    glam::{Vec2, Vec3, Vec4},
    light_sample::{SHORT, ray_origin, segment},
    math::{dot3, greater, lesser},
};

/// Number of rays of a block.
const BLOCK: usize = 8;
/// Minimum number of blocks, or groups of them, per task of a thread.
const A_TASK: usize = 64;
/// Minimum number of groups of blocks that a thread evaluates.
const GROUPS_ANSWERED: usize = 256;

/// Number of bits of a coordinate in a directional light's key.
const SUN_BITS: u32 = KEY_BITS / 2;
/// Number of bits of a coordinate in a point light's key, which begins with the face.
const LAMP_BITS: u32 = (KEY_BITS - FACE_BITS) / 2;
const FACE_BITS: u32 = 3;

/// Rays on a face.
#[derive(Debug)]
pub(super) struct FaceRays {
    pub(super) face: u32,
    /// Positions of the blocks, separate from their other data, since most casters near a block
    /// miss all of its rays.
    places: Vec<BlockPlaces>,
    blocks: Vec<RayBlock>,
    pub(super) open: Open,
    /// Boxes around eight blocks at a time, then around eight of these, and so on up to one.
    pub(super) levels: Vec<Vec<Boxes>>,
}

/// Projections of the origins of eight rays.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
struct BlockPlaces {
    across: [f32; BLOCK],
    down: [f32; BLOCK],
    depth: [f32; BLOCK],
}

/// Eight rays. A last partial block repeats its last one.
#[derive(Clone, Copy, Debug, Default)]
struct RayBlock {
    /// Ray origins, world space.
    origin: [[f32; BLOCK]; 3],
    /// Triangle on which each ray starts.
    own: [u32; BLOCK],
    pixel: [u32; BLOCK],
}

/// Direction of all rays.
pub(super) enum Rays {
    /// Rays to a directional light. Boxed, since this is much larger than a position.
    Parallel(Box<FourSegments>),
    /// Rays to a light at this position.
    Towards(Vec3),
}

impl Rays {
    pub(super) fn from_uniforms(uniforms: &ExactUniforms, frame: &LightFrame) -> Self {
        if frame.is_lamp {
            return Self::Towards(uniforms.light.center.truncate());
        }
        let to_light = segment(&uniforms.light, Vec3::ZERO, Vec2::ZERO, uniforms.far);
        let vector = to_light.to_array().map(Vec4::splat);
        let from_nowhere = [Vec4::ZERO; 3];
        let rays = FourSegments::new(from_nowhere, vector, longest_axis(to_light));
        Self::Parallel(Box::new(rays))
    }
}

/// Visibility of each pixel, as bits of floats, which several threads write.
pub(super) struct Mask(Vec<AtomicU32>);

impl Mask {
    /// Returns the visibilities.
    pub(super) fn into_numbers(self) -> Vec<f32> {
        let number = |bits: AtomicU32| f32::from_bits(bits.into_inner());
        self.0.into_iter().map(number).collect()
    }

    #[inline(always)]
    fn set_lit(&self, pixel: u32) {
        self.0[pixel as usize].store(1.0_f32.to_bits(), Ordering::Relaxed);
    }
}

/// Rays of an image, face by face, and the mask with all of them blocked.
pub(super) struct AllRays {
    pub(super) faces: Vec<FaceRays>,
    pub(super) mask: Mask,
}

/// Creates the rays of all receivers that face the light and are in reach of casters.
pub(super) fn make_rays(
    simd: Simd,
    uniforms: &ExactUniforms,
    frame: &LightFrame,
    receivers: &Receivers,
) -> AllRays {
    // Place the receivers, one band per thread.
    let mask = Mask((0..receivers.len()).map(|_| AtomicU32::new(0)).collect());
    let threads = umbrage_core::parallel::current_num_threads();
    let band = receivers
        .len()
        .div_ceil(threads)
        .next_multiple_of(BATCH)
        .max(BATCH);
    let firsts: Vec<usize> = (0..receivers.len()).step_by(band).collect();
    let place_band = |first: usize| {
        let band = first..receivers.len().min(first + band);
        let mask = &mask;
        if frame.is_lamp {
            simd.run_task(RayPlace::<true> {
                uniforms,
                frame,
                receivers,
                band,
                mask,
            })
        } else {
            simd.run_task(RayPlace::<false> {
                uniforms,
                frame,
                receivers,
                band,
                mask,
            })
        }
    };
    let parts: Vec<Vec<Entry>> = firsts.into_par_iter().map(place_band).collect();
    // Sort the rays along the curve, and split them by face.
    let sorted = sort(&parts);
    let source = RaySource {
        simd,
        uniforms,
        frame,
        receivers,
        sorted: &sorted,
    };
    let mut faces = Vec::new();
    let mut first = 0;
    for face in 0..frame.faces() {
        let end = if frame.is_lamp {
            sorted.entries_below((face + 1) << (2 * LAMP_BITS))
        } else {
            sorted.len()
        };
        if first < end {
            faces.push(FaceRays::new(&source, face, first..end));
        }
        first = end;
    }
    AllRays { faces, mask }
}

/// Task that places a band of receivers, in whole batches except the last. Returns entries of the
/// rays to test, and marks the pixels that are lit without a test.
struct RayPlace<'a, const LAMP: bool> {
    uniforms: &'a ExactUniforms,
    frame: &'a LightFrame,
    receivers: &'a Receivers,
    band: Range<usize>,
    mask: &'a Mask,
}

impl<const LAMP: bool> SimdTask for RayPlace<'_, LAMP> {
    type Output = Vec<Entry>;

    #[inline(always)]
    fn run(self) -> Vec<Entry> {
        let mut entries = Vec::with_capacity(self.band.len());
        for first in self.band.clone().step_by(BATCH) {
            let end = self.band.end.min(first + BATCH);
            self.place_batch(first..end, &mut entries);
        }
        entries
    }
}

impl<const LAMP: bool> RayPlace<'_, LAMP> {
    #[inline(always)]
    fn place_batch(&self, batch: Range<usize>, entries: &mut Vec<Entry>) {
        let receives = &self.receivers.receives[batch.clone()];
        if !receives.contains(&true) {
            batch.for_each(|pixel| self.mask.set_lit(pixel as u32));
            return;
        }
        let count = batch.len();
        let span = self.receivers.span(batch.start, count);
        let mut padded = PaddedReceivers::new();
        let receivers = ReceiverBatch::from(&span, 0, &mut padded);
        let u = self.uniforms;
        // Copy the inputs, so that the loop is vectorised: its outputs can't alias them.
        let frame = *self.frame;
        let eye = u.eye.truncate();
        let sun = segment(&u.light, Vec3::ZERO, Vec2::ZERO, u.far);
        let lamp = u.light.center.truncate();
        let to_half = frame.half.recip() * 0.5;
        // No ray to a directional light hits a caster beyond this edge.
        let rim = frame.half + frame.margin(0.0);
        let mut key = [0; BATCH];
        let mut faces_light = [false; BATCH];
        let mut is_outside = [false; BATCH];
        // Compute each receiver's key.
        for i in 0..BATCH {
            let n = receivers.normal(i);
            let o = ray_origin(receivers.position(i), n, eye, u.grid.w);
            // Compute the segment to a point as in `segment`.
            let d = if LAMP { (lamp - o) * SHORT } else { sun };
            let point = frame.look_up_as::<LAMP>(frame.place_as::<LAMP>(o), longest_axis(d));
            let at = point.on_face * to_half + 0.5;
            key[i] = if LAMP {
                let on_face = curve_bits(at.x, LAMP_BITS) | curve_bits(at.y, LAMP_BITS) << 1;
                point.face << (2 * LAMP_BITS) | on_face
            } else {
                curve_bits(at.x, SUN_BITS) | curve_bits(at.y, SUN_BITS) << 1
            };
            faces_light[i] = dot3(n, d) > 0.0;
            let size = point.on_face.abs();
            is_outside[i] = !LAMP && (size.x > rim.x || size.y > rim.y);
        }
        // Mark pixels that are lit without a test; collect the others.
        for i in 0..count {
            let pixel = (batch.start + i) as u32;
            if !receives[i] || faces_light[i] && is_outside[i] {
                self.mask.set_lit(pixel);
            } else if faces_light[i] {
                entries.push(Entry::new(key[i], pixel));
            }
        }
    }
}

/// Least float from which, up to twice its value, all floats are integers.
const WHOLE: f32 = 8_388_608.0;

/// Returns the first bits of a number clamped to 0..=1, with a zero above each.
#[inline(always)]
fn curve_bits(number: f32, count: u32) -> u32 {
    let most = ((1_u32 << count) - 1) as f32;
    let bounded = lesser(greater(number * most, 0.0), most);
    // Adding 2^23 moves the integer into the lowest bits: a conversion without range checks.
    let bits = (bounded + WHOLE).to_bits() & 0xffff;
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// Inputs of rays.
struct RaySource<'a> {
    simd: Simd,
    uniforms: &'a ExactUniforms,
    frame: &'a LightFrame,
    receivers: &'a Receivers,
    sorted: &'a Sorted,
}

/// Task that creates up to eight blocks of a face. Returns boxes around them, and their bounding
/// box.
struct MakeBlocks<'a, const LAMP: bool> {
    source: &'a RaySource<'a>,
    face: u32,
    entries: Range<usize>,
    places: &'a mut [BlockPlaces],
    blocks: &'a mut [RayBlock],
}

impl<const LAMP: bool> SimdTask for MakeBlocks<'_, LAMP> {
    type Output = (Boxes, FaceBox);

    #[inline(always)]
    fn run(self) -> (Boxes, FaceBox) {
        let make = BlockMaker::<LAMP> {
            source: self.source,
            face: self.face,
            end: self.entries.end,
        };
        let mut bounds = [FaceBox::EMPTY; BOXES];
        for (i, first) in self.entries.step_by(BLOCK).enumerate() {
            let place = &mut self.places[i];
            make.block(first, place, &mut self.blocks[i]);
            for ray in 0..BLOCK {
                let on_face = Vec2::new(place.across[ray], place.down[ray]);
                bounds[i].add(on_face, place.depth[ray]);
            }
        }
        Boxes::around_boxes(&bounds)
    }
}

/// Creates blocks of a face from sorted entries, up to an end.
struct BlockMaker<'a, const LAMP: bool> {
    source: &'a RaySource<'a>,
    face: u32,
    end: usize,
}

impl<const LAMP: bool> BlockMaker<'_, LAMP> {
    /// Creates a block from the entries starting at `first`.
    #[inline(always)]
    fn block(&self, first: usize, places: &mut BlockPlaces, block: &mut RayBlock) {
        let r = self.source.receivers;
        let mut position = [[0.0; BLOCK]; 3];
        let mut normal = [[0.0; BLOCK]; 3];
        // Gather the receivers.
        for i in 0..BLOCK {
            let entry = (first + i).min(self.end - 1);
            let pixel = self.source.sorted.get(entry).pixel();
            block.pixel[i] = pixel;
            let pixel = pixel as usize;
            block.own[i] = r.triangle[pixel];
            position[0][i] = r.x[pixel];
            position[1][i] = r.y[pixel];
            position[2][i] = r.z[pixel];
            normal[0][i] = r.nx[pixel];
            normal[1][i] = r.ny[pixel];
            normal[2][i] = r.nz[pixel];
        }
        // Copy the inputs, so that the loop is vectorised: its outputs can't alias them.
        let frame = *self.source.frame;
        let u = self.source.uniforms;
        let eye = u.eye.truncate();
        let mut origin = [[0.0; BLOCK]; 3];
        let mut made = BlockPlaces::default();
        // Compute the rays and their positions on the face.
        for i in 0..BLOCK {
            let p = Vec3::new(position[0][i], position[1][i], position[2][i]);
            let n = Vec3::new(normal[0][i], normal[1][i], normal[2][i]);
            let o = ray_origin(p, n, eye, u.grid.w);
            let point: FramePoint =
                frame.look_up_as::<LAMP>(frame.place_as::<LAMP>(o), self.face / 2);
            origin[0][i] = o.x;
            origin[1][i] = o.y;
            origin[2][i] = o.z;
            made.across[i] = point.on_face.x;
            made.down[i] = point.on_face.y;
            made.depth[i] = point.depth;
        }
        block.origin = origin;
        *places = made;
    }
}

impl BlockPlaces {
    /// Returns a bit for each ray that may hit a caster with this reach.
    #[inline(always)]
    fn near_rays(&self, reach: &Reach) -> u32 {
        let mut bits = 0;
        for first in (0..BLOCK).step_by(SEGMENT_LANES) {
            let x = four(&self.across, first);
            let y = four(&self.down, first);
            let across = x.cmpge(Vec4::splat(reach.low.x)) & x.cmple(Vec4::splat(reach.high.x));
            let down = y.cmpge(Vec4::splat(reach.low.y)) & y.cmple(Vec4::splat(reach.high.y));
            let deep = four(&self.depth, first).cmpge(Vec4::splat(reach.nearest));
            bits |= (across & down & deep).bitmask() << first;
        }
        bits
    }
}

#[inline(always)]
fn four(numbers: &[f32; BLOCK], first: usize) -> Vec4 {
    Vec4::from_slice(&numbers[first..first + SEGMENT_LANES])
}

impl FaceRays {
    /// Creates the rays of some entries, all on one face.
    fn new(source: &RaySource<'_>, face: u32, entries: Range<usize>) -> Self {
        const A_GROUP: usize = BLOCK * BOXES;
        let count = entries.len();
        let groups = count.div_ceil(A_GROUP);
        let make = |group: usize, places: &mut [BlockPlaces], blocks: &mut [RayBlock]| {
            let first = entries.start + group * A_GROUP;
            let entries = first..entries.end.min(first + A_GROUP);
            if source.frame.is_lamp {
                source.simd.run_task(MakeBlocks::<true> {
                    source,
                    face,
                    entries,
                    places,
                    blocks,
                })
            } else {
                source.simd.run_task(MakeBlocks::<false> {
                    source,
                    face,
                    entries,
                    places,
                    blocks,
                })
            }
        };
        // Create the blocks in groups of eight.
        let mut places = vec![BlockPlaces::default(); groups * BOXES];
        let mut blocks = vec![RayBlock::default(); groups * BOXES];
        let rooms = places
            .par_chunks_mut(BOXES)
            .zip(blocks.par_chunks_mut(BOXES));
        let (boxes, mut around): (Vec<Boxes>, Vec<FaceBox>) = rooms
            .enumerate()
            .with_min_len(A_TASK)
            .map(|(group, (places, blocks))| make(group, places, blocks))
            .unzip();
        // Build the levels of boxes up to one.
        let mut levels = vec![boxes];
        while around.len() > 1 {
            let above = around.chunks(BOXES).map(Boxes::around_boxes);
            let (boxes, bounds) = above.unzip();
            levels.push(boxes);
            around = bounds;
        }
        let block_count = count.div_ceil(BLOCK);
        let in_last = count - (block_count - 1) * BLOCK;
        Self {
            face,
            places,
            blocks,
            open: Open::all(block_count, in_last),
            levels,
        }
    }

    /// Blocks the rays of a block that hit a caster, except those that start on it.
    #[inline(always)]
    pub(super) fn hide(
        &self,
        block: usize,
        rays: &Rays,
        reach: &Reach,
        caster: u32,
        corners: impl Fn() -> [Vec3; 3],
        holes: Option<CasterHoles<'_>>,
    ) {
        let near = self.open.rays(block) & self.places[block].near_rays(reach);
        if near == 0 {
            return;
        }
        let wanted = near & !self.of_triangle(block, caster);
        if wanted == 0 {
            return;
        }
        let mut blocked = wanted & self.hits(block, rays, wanted, &corners());
        if let Some(holes) = holes {
            blocked &= !self.through_holes(block, blocked, caster, corners(), holes);
        }
        if blocked != 0 {
            self.open.close_rays(block, blocked);
        }
    }

    /// Returns a bit for each ray that hits a caster at a transparent texel. All given rays of the
    /// block hit the caster.
    fn through_holes(
        &self,
        block: usize,
        mut rays: u32,
        caster: u32,
        corners: [Vec3; 3],
        holes: CasterHoles<'_>,
    ) -> u32 {
        let [x, y, z] = &self.blocks[block].origin;
        let mut bits = 0;
        while let Some(ray) = take_lowest(&mut rays) {
            let o = Vec3::new(x[ray], y[ray], z[ray]);
            bits |= u32::from(holes.are_met(caster, corners, o)) << ray;
        }
        bits
    }

    /// Returns a bit for each ray of a block that starts on a triangle.
    #[inline(always)]
    fn of_triangle(&self, block: usize, triangle: u32) -> u32 {
        let mut bits = 0;
        for (ray, &own) in self.blocks[block].own.iter().enumerate() {
            bits |= u32::from(own == triangle) << ray;
        }
        bits
    }

    /// Returns a bit for each ray of a block that hits a triangle. Bits outside `wanted` are
    /// undefined.
    #[inline(always)]
    fn hits(&self, block: usize, rays: &Rays, wanted: u32, corners: &[Vec3; 3]) -> u32 {
        let mut bits = 0;
        for first in (0..BLOCK).step_by(SEGMENT_LANES) {
            if wanted >> first & 0xf == 0 {
                continue;
            }
            let [x, y, z] = &self.blocks[block].origin;
            let origin = [four(x, first), four(y, first), four(z, first)];
            let segments = match rays {
                Rays::Parallel(rays) => rays.with_origins(origin),
                Rays::Towards(lamp) => {
                    // Compute the segment to a point as in `segment`.
                    let to_lamp = |k: usize| (Vec4::splat(lamp[k]) - origin[k]) * SHORT;
                    // Rays of a face have its axis as their longest one.
                    let axis = self.face / 2;
                    FourSegments::new(origin, [to_lamp(0), to_lamp(1), to_lamp(2)], axis)
                }
            };
            bits |= segments.hits(*corners) << first;
        }
        bits
    }

    /// Marks in the mask the rays that are not known to be blocked.
    pub(super) fn answer(&self, mask: &Mask) {
        self.open.for_each(GROUPS_ANSWERED, |block, mut rays| {
            while let Some(ray) = take_lowest(&mut rays) {
                mask.set_lit(self.blocks[block].pixel[ray]);
            }
        });
    }
}
