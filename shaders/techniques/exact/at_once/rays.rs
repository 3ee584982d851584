//! The rays of all receivers in the order in which the light sees them, and boxes around them, level by level.
//!
//! Rays are sorted along a curve over the light's frame that goes through all of a square before it leaves it (Morton 1966, "A Computer Oriented
//! Geodetic Data Base and a New Technique in File Sequencing"), so that eight that follow one another lie side by side, and so do eight such
//! blocks, and so on: wherever many pixels see little of the scene, or few see much, a box holds the same number of rays.

use super::{
    super::{
        ExactUniforms,
        light_frame::{FramePoint, LightFrame},
    },
    boxes::{BOXES, Boxes, FaceBox},
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU8, Ordering};
use umbrage_core::{
    Receivers, Simd, SimdTask,
    bvh::{FourSegments, SEGMENT_LANES, longest_axis},
    glam::{Vec2, Vec3, Vec4},
    light_sample::{SHORT, ray_origin, segment},
    math::{dot3, greater, lesser},
};

/// Rays of a block.
const BLOCK: usize = 8;
/// Receivers that are placed at a time.
const BATCH: usize = 64;
/// Receivers that a thread places before it takes others.
const BAND: usize = 64 * BATCH;
/// Blocks, or groups of them, that a thread makes at least.
const A_TASK: usize = 64;

/// Bits of a pixel's number in a key: as many as the largest picture needs.
const PIXEL_BITS: u32 = 29;
/// Bits of a coordinate in a key.
const COORDINATE_BITS: u32 = 16;

/// The rays on a face.
#[derive(Debug)]
pub(super) struct FaceRays {
    pub(super) face: u32,
    blocks: Vec<Block>,
    /// For each block a bit for each ray that is not known to be blocked.
    open: Vec<AtomicU8>,
    /// Boxes around eight blocks at a time, then around eight of these, and so on up to one.
    pub(super) levels: Vec<Vec<Boxes>>,
}

/// Eight rays. A last block that is not full has its last one several times.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// World space.
    origin: [[f32; BLOCK]; 3],
    pixel: [u32; BLOCK],
    count: usize,
}

/// Which way rays go.
pub(super) enum Rays {
    /// Those of a directional light, from anywhere.
    Parallel(FourSegments),
    /// Those of a light at this position.
    Towards(Vec3),
}

impl Rays {
    pub(super) fn of(uniforms: &ExactUniforms, frame: &LightFrame) -> Self {
        if frame.is_lamp {
            return Self::Towards(uniforms.light.center.truncate());
        }
        let to_light = segment(&uniforms.light, Vec3::ZERO, Vec2::ZERO, uniforms.far);
        let vector = to_light.to_array().map(Vec4::splat);
        let from_nowhere = [Vec4::ZERO; 3];
        Self::Parallel(FourSegments::new(
            from_nowhere,
            vector,
            longest_axis(to_light),
        ))
    }
}

/// Makes the rays of all receivers that face the light, face by face.
pub(super) fn make_rays(
    simd: Simd,
    uniforms: &ExactUniforms,
    frame: &LightFrame,
    receivers: &Receivers,
) -> Vec<FaceRays> {
    let mut placed = place_all(simd, uniforms, frame, receivers);
    placed.keys.par_sort_unstable();
    let end_of = |face: u32| {
        let end = u64::from(face + 1) << (2 * COORDINATE_BITS + PIXEL_BITS);
        placed.keys.partition_point(|&key| key < end)
    };
    let mut out = Vec::new();
    let mut first = 0;
    for face in 0..frame.faces() {
        let end = end_of(face);
        if first < end {
            out.push(FaceRays::new(simd, frame, face, &placed, first..end));
        }
        first = end;
    }
    out
}

/// Where the rays of receivers begin, and their order.
struct Placed {
    /// World space, by axis and pixel.
    origin: [Vec<f32>; 3],
    /// Face, place along the curve, and pixel, of all rays that face the light.
    keys: Vec<u64>,
}

fn place_all(
    simd: Simd,
    uniforms: &ExactUniforms,
    frame: &LightFrame,
    receivers: &Receivers,
) -> Placed {
    let mut origin = [(); 3].map(|()| vec![0.0; receivers.len()]);
    let [x, y, z] = origin.each_mut().map(|axis| axis.par_chunks_mut(BAND));
    let bands = x.zip(y).zip(z).enumerate();
    let keys: Vec<Vec<u64>> = bands
        .map(|(band, ((x, y), z))| {
            let origin = [x, y, z];
            let first = band * BAND;
            if frame.is_lamp {
                simd.run_task(Place::<true> {
                    uniforms,
                    frame,
                    receivers,
                    first,
                    origin,
                })
            } else {
                simd.run_task(Place::<false> {
                    uniforms,
                    frame,
                    receivers,
                    first,
                    origin,
                })
            }
        })
        .collect();
    Placed {
        origin,
        keys: keys.concat(),
    }
}

/// Places a band of receivers: writes where their rays begin, and returns keys.
struct Place<'a, const LAMP: bool> {
    uniforms: &'a ExactUniforms,
    frame: &'a LightFrame,
    receivers: &'a Receivers,
    first: usize,
    origin: [&'a mut [f32]; 3],
}

impl<const LAMP: bool> SimdTask for Place<'_, LAMP> {
    type Output = Vec<u64>;

    #[inline(always)]
    fn run(mut self) -> Vec<u64> {
        let count = self.origin[0].len();
        let mut keys = Vec::with_capacity(count);
        for at in (0..count).step_by(BATCH) {
            let end = count.min(at + BATCH);
            let receives = &self.receivers.receives[self.first + at..self.first + end];
            if receives.contains(&true) {
                self.place_batch(at..end, &mut keys);
            }
        }
        keys
    }
}

impl<const LAMP: bool> Place<'_, LAMP> {
    #[inline(always)]
    fn place_batch(&mut self, part: std::ops::Range<usize>, keys: &mut Vec<u64>) {
        let u = self.uniforms;
        // Copies, so that the loop becomes one of vector instructions: what it writes can't be what it reads.
        let frame = *self.frame;
        let eye = u.eye.truncate();
        let sun = segment(&u.light, Vec3::ZERO, Vec2::ZERO, u.far);
        let lamp = u.light.center.truncate();
        let to_half = frame.half.recip() * 0.5;
        let count = part.len();
        let first = self.first + part.start;
        let read = |numbers: &[f32]| {
            let mut out = [0.0; BATCH];
            out[..count].copy_from_slice(&numbers[first..first + count]);
            out
        };
        let r = self.receivers;
        let position = [&r.x, &r.y, &r.z].map(|axis| read(axis));
        let normal = [&r.nx, &r.ny, &r.nz].map(|axis| read(axis));
        let mut origin = [[0.0; BATCH]; 3];
        let mut key = [0; BATCH];
        let mut faces_light = [false; BATCH];
        for i in 0..BATCH {
            let vector = |axes: &[[f32; BATCH]; 3]| Vec3::new(axes[0][i], axes[1][i], axes[2][i]);
            let n = vector(&normal);
            let o = ray_origin(vector(&position), n, eye, u.grid.w);
            // As `segment` has it of a point.
            let d = if LAMP { (lamp - o) * SHORT } else { sun };
            let point = frame.look_up_as::<LAMP>(frame.place_as::<LAMP>(o), longest_axis(d));
            let at = point.on_face * to_half + 0.5;
            let place = curve_bits(at.x) | curve_bits(at.y) << 1;
            let place = u64::from(point.face) << (2 * COORDINATE_BITS) | u64::from(place);
            key[i] = place << PIXEL_BITS | (first + i) as u64;
            faces_light[i] = dot3(n, d) > 0.0;
            origin[0][i] = o.x;
            origin[1][i] = o.y;
            origin[2][i] = o.z;
        }
        for (to, from) in self.origin.iter_mut().zip(&origin) {
            to[part.clone()].copy_from_slice(&from[..count]);
        }
        let receives = &r.receives[first..first + count];
        for i in 0..count {
            if receives[i] && faces_light[i] {
                keys.push(key[i]);
            }
        }
    }
}

/// Numbers from here to twice this are whole.
const WHOLE: f32 = 8_388_608.0;

/// Returns the bits of a number of 0 to 1 (others are taken for the nearest of these), with a zero above each.
#[inline(always)]
fn curve_bits(number: f32) -> u32 {
    let most = ((1_u32 << COORDINATE_BITS) - 1) as f32;
    let bounded = lesser(greater(number * most, 0.0), most);
    // 2^23 more has the whole number in its lowest bits: a conversion that knows no bounds.
    let bits = (bounded + WHOLE).to_bits() & 0xffff;
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

impl Block {
    fn new(placed: &Placed, keys: &[u64]) -> Self {
        let mut out = Self {
            origin: [[0.0; BLOCK]; 3],
            pixel: [0; BLOCK],
            count: keys.len(),
        };
        for i in 0..BLOCK {
            let key = keys[i.min(keys.len() - 1)];
            let pixel = key & ((1 << PIXEL_BITS) - 1);
            out.pixel[i] = pixel as u32;
            for (axis, all) in out.origin.iter_mut().zip(&placed.origin) {
                axis[i] = all[pixel as usize];
            }
        }
        out
    }

    fn all_open(&self) -> AtomicU8 {
        AtomicU8::new(u8::MAX >> (BLOCK - self.count))
    }
}

/// Makes boxes around eight blocks or fewer, and one around all of them.
struct BoxBlocks<'a> {
    frame: &'a LightFrame,
    face: u32,
    blocks: &'a [Block],
}

impl SimdTask for BoxBlocks<'_> {
    type Output = (Boxes, FaceBox);

    #[inline(always)]
    fn run(self) -> (Boxes, FaceBox) {
        let mut bounds = [FaceBox::EMPTY; BOXES];
        for (bounds, block) in bounds.iter_mut().zip(self.blocks) {
            let [x, y, z] = &block.origin;
            for i in 0..BLOCK {
                let point = self.place(Vec3::new(x[i], y[i], z[i]));
                bounds.add(point.on_face, point.depth);
            }
        }
        Boxes::around(&bounds)
    }
}

impl BoxBlocks<'_> {
    #[inline(always)]
    fn place(&self, o: Vec3) -> FramePoint {
        let frame = self.frame;
        if frame.is_lamp {
            frame.look_up_as::<true>(frame.place_as::<true>(o), self.face / 2)
        } else {
            frame.look_up_as::<false>(frame.place_as::<false>(o), 0)
        }
    }
}

impl FaceRays {
    /// Makes the rays of some keys, all on one face.
    fn new(
        simd: Simd,
        frame: &LightFrame,
        face: u32,
        placed: &Placed,
        keys: std::ops::Range<usize>,
    ) -> Self {
        let blocks: Vec<Block> = placed.keys[keys]
            .par_chunks(BLOCK)
            .with_min_len(A_TASK)
            .map(|keys| Block::new(placed, keys))
            .collect();
        let eight = blocks.par_chunks(BOXES).with_min_len(A_TASK);
        let (boxes, mut around): (Vec<Boxes>, Vec<FaceBox>) = eight
            .map(|blocks| {
                simd.run_task(BoxBlocks {
                    frame,
                    face,
                    blocks,
                })
            })
            .unzip();
        let mut levels = vec![boxes];
        while around.len() > 1 {
            let above = around.chunks(BOXES).map(Boxes::around);
            let (boxes, bounds) = above.unzip();
            levels.push(boxes);
            around = bounds;
        }
        Self {
            face,
            open: blocks.iter().map(Block::all_open).collect(),
            blocks,
            levels,
        }
    }

    /// Returns a bit for each ray of a block that is not known to be blocked.
    #[inline(always)]
    pub(super) fn open(&self, block: usize) -> u32 {
        // Another thread's news may come late: then a ray that is blocked is asked again.
        self.open[block].load(Ordering::Relaxed).into()
    }

    /// Notes that rays of a block are blocked.
    #[inline(always)]
    pub(super) fn close(&self, block: usize, rays: u32) {
        self.open[block].fetch_and(!(rays as u8), Ordering::Relaxed);
    }

    /// Returns a bit for each ray of a block that meets a triangle.
    #[inline(always)]
    pub(super) fn hits(&self, block: usize, rays: &Rays, corners: [Vec3; 3]) -> u32 {
        let mut bits = 0;
        for first in (0..BLOCK).step_by(SEGMENT_LANES) {
            let four = |axis: &[f32; BLOCK]| Vec4::from_slice(&axis[first..first + SEGMENT_LANES]);
            let origin = self.blocks[block].origin.each_ref().map(four);
            let segments = match rays {
                Rays::Parallel(rays) => rays.from_origins(origin),
                Rays::Towards(lamp) => {
                    // As `segment` has it of a point.
                    let to_lamp = |k: usize| (Vec4::splat(lamp[k]) - origin[k]) * SHORT;
                    // Rays of a face have its axis for their longest one.
                    let axis = self.face / 2;
                    FourSegments::new(origin, [0, 1, 2].map(to_lamp), axis)
                }
            };
            bits |= segments.hits(corners) << first;
        }
        bits
    }

    /// Returns the pixel of a block's ray.
    #[inline(always)]
    pub(super) fn pixel(&self, block: usize, ray: usize) -> usize {
        self.blocks[block].pixel[ray] as usize
    }

    /// Calls `tell` with the pixel of each ray that is not known to be blocked.
    pub(super) fn each_open(&self, mut tell: impl FnMut(usize)) {
        for (number, block) in self.blocks.iter().enumerate() {
            let open = self.open(number);
            for (ray, &pixel) in block.pixel.iter().enumerate() {
                if open >> ray & 1 == 1 {
                    tell(pixel as usize);
                }
            }
        }
    }
}
