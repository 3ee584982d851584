//! Comparisons at the taps of a pattern that is laid over an ellipse or a parallelogram of the map. Every filter over a pattern
//! uses them.
//!
//! Receivers are lanes: all receivers of a batch go to their first tap, then all to their second. Each lane adds up its taps in
//! the order of the shader's loop, so both halves agree to the bit.

#![expect(
    clippy::needless_range_loop,
    reason = "one index into many arrays: that is what compilers turn into vector lanes"
)]

use crate::{
    filtering::sample_pattern::{PatternShape, PatternTable, TapSet, affine, noise_index, wrapped},
    lanes::batch::{BATCH, Batch, Lanes},
    shadow_map::{coord::ShadowCoord, texel_compare::DepthMap},
};
use glam::{UVec2, Vec2, Vec4};
use umbrage_core::Module;

/// The WGSL half. It reads the kernel's first image and table, and needs the map's modules and
/// [`PATTERN`](crate::filtering::sample_pattern::PATTERN).
pub(crate) const PATTERN_TAPS: Module = Module {
    name: "pattern_taps",
    text: include_str!("pattern_taps.wgsl"),
};

/// The depth that taps outside the map read: farther than any stored depth, so such taps are lit and block nothing.
const OUTSIDE_DEPTH: f32 = 2.0;
/// The texel index of taps outside the map. All its bits are set, so a bitwise or with it gives it again.
const NO_TEXEL: u32 = u32::MAX;
/// 2^23: from here on a float's unit in the last place is 1 or more, so that floats are whole numbers, and up to 2^24 the bits
/// of the mantissa are the number less 2^23.
const TWO_POW_23: f32 = 8_388_608.0;
/// Batches with at most this many receivers go through loops of half the width.
pub(crate) const HALF_BATCH: usize = BATCH / 2;

/// Returns the pattern's turn (cos, sin, shift x, shift y) at the pixel `offset` pixels right of `first`. `mask` is 0 if the
/// pattern is turned nowhere, else one less than the number of turns.
///
/// Panics if the table has fewer turns than `mask` says.
#[inline(always)]
pub(crate) fn turn_at(table: &PatternTable, mask: u32, first: UVec2, offset: usize) -> Vec4 {
    let x = first.x.wrapping_add(offset as u32);
    let turn = noise_index(x, first.y) & mask;
    table.turns[turn as usize]
}

/// Half axes of many receivers' kernels, texels: x and y of the first axis, then x and y of the second.
pub(crate) type Axes = [Lanes<f32>; 4];

/// How a pattern is laid over the map at one receiver.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KernelPlacement {
    /// Half axes, texels: x and y of the first, then x and y of the second.
    pub(crate) axes: Vec4,
    /// The shift of a square pattern, 0..2; zero for discs.
    pub(crate) shift: Vec2,
    /// Further numbers of the receiver. The technique that places the kernel gives them their meaning.
    pub(crate) extra: [f32; EXTRA_COUNT],
}

/// The length of [`KernelPlacement::extra`].
pub(crate) const EXTRA_COUNT: usize = 6;

/// Up to [`BATCH`] receivers, an array for each field. Only the lanes before `count` hold receivers.
#[derive(Clone)]
pub(crate) struct ReceiverLanes {
    /// How many receivers there are.
    pub(crate) count: usize,
    /// [`ShadowCoord::depth`].
    pub(crate) depth: Lanes<f32>,
    /// [`KernelPlacement::axes`].
    pub(crate) axes: Axes,
    /// [`KernelPlacement::extra`].
    pub(crate) extra: [Lanes<f32>; EXTRA_COUNT],
    /// Each receiver's number in its batch.
    pub(crate) number: Lanes<usize>,
    /// [`ShadowCoord::texel`].
    x: Lanes<f32>,
    y: Lanes<f32>,
    /// [`KernelPlacement::shift`].
    pub(crate) shift: [Lanes<f32>; 2],
    /// [`ShadowCoord::gradient`].
    right: Lanes<f32>,
    down: Lanes<f32>,
    /// [`ShadowCoord::deepest`].
    deepest: Lanes<f32>,
    /// The index of the first texel of the receiver's layer.
    layer_start: Lanes<u32>,
}

impl ReceiverLanes {
    /// Returns those of a batch's first `count` receivers that the map sees and for which `place_kernel` returns a placement.
    /// `place_kernel` takes a receiver's place on the map and its number in the batch; `size` is the map's side, texels.
    #[inline(always)]
    pub(crate) fn seen(
        batch: &Batch,
        count: usize,
        size: i32,
        mut place_kernel: impl FnMut(&ShadowCoord, usize) -> Option<KernelPlacement>,
    ) -> Self {
        let zero = [0.0; BATCH];
        let mut receivers = Self {
            count: 0,
            depth: zero,
            axes: [zero; 4],
            extra: [zero; EXTRA_COUNT],
            number: [0; BATCH],
            x: zero,
            y: zero,
            right: zero,
            down: zero,
            deepest: zero,
            shift: [zero; 2],
            layer_start: [0; BATCH],
        };
        for number in 0..count.min(BATCH) {
            let l = batch.lookup(number);
            if l.seen
                && let Some(placement) = place_kernel(&l, number)
            {
                receivers.push(&l, number, size, placement);
            }
        }
        receivers
    }

    #[inline(always)]
    fn push(&mut self, l: &ShadowCoord, number: usize, size: i32, placement: KernelPlacement) {
        let i = self.count;
        self.number[i] = number;
        self.layer_start[i] = (l.layer * size * size) as u32;
        self.x[i] = l.texel.x;
        self.y[i] = l.texel.y;
        self.depth[i] = l.depth;
        self.right[i] = l.gradient.x;
        self.down[i] = l.gradient.y;
        self.deepest[i] = l.deepest;
        self.shift[0][i] = placement.shift.x;
        self.shift[1][i] = placement.shift.y;
        self.axes[0][i] = placement.axes.x;
        self.axes[1][i] = placement.axes.y;
        self.axes[2][i] = placement.axes.z;
        self.axes[3][i] = placement.axes.w;
        for (lanes, extra) in self.extra.iter_mut().zip(placement.extra) {
            lanes[i] = extra;
        }
        self.count += 1;
    }

    /// Returns each receiver's half axes times its own factor.
    #[inline(always)]
    pub(crate) fn scaled_axes(&self, factors: &Lanes<f32>) -> Axes {
        let mut axes = self.axes;
        for axis in &mut axes {
            for i in 0..BATCH {
                axis[i] *= factors[i];
            }
        }
        axes
    }
}

/// The map and the rules by which taps compare with it.
#[derive(Clone, Copy)]
pub(crate) struct Comparisons<'a> {
    pub(crate) map: DepthMap<'a>,
    /// Squares are shifted, discs are not.
    pub(crate) shape: PatternShape,
    /// Whether the depth compared follows the receiver's plane, so that it differs from tap to tap.
    pub(crate) follows_plane: bool,
}

/// What many receivers compare at one tap each.
pub(crate) struct Depths {
    /// The depth stored in the map, or [`OUTSIDE_DEPTH`].
    pub(crate) stored: Lanes<f32>,
    /// The receiver's own depth there.
    pub(crate) receiver: Lanes<f32>,
}

impl Comparisons<'_> {
    /// Returns how many taps of a set see each receiver lit.
    #[inline(always)]
    pub(crate) fn lit(&self, r: &ReceiverLanes, axes: &Axes, set: &TapSet) -> Lanes<i32> {
        if r.count <= HALF_BATCH {
            self.lit_in::<HALF_BATCH>(r, axes, set)
        } else {
            self.lit_in::<BATCH>(r, axes, set)
        }
    }

    #[inline(always)]
    fn lit_in<const N: usize>(&self, r: &ReceiverLanes, axes: &Axes, set: &TapSet) -> Lanes<i32> {
        let mut lit = [0; BATCH];
        for &tap in &set.taps {
            let texels = self.texels_at_tap::<N>(r, axes, tap.truncate());
            let depths = self.depths_in::<N>(r, &texels);
            for (i, lit) in lit[..N].iter_mut().enumerate() {
                *lit += i32::from(depths.receiver[i] <= depths.stored[i]);
            }
        }
        lit
    }

    /// Returns the depths at one point of the pattern for each receiver: `x` and `y`, -1..1, already shifted.
    #[inline(always)]
    pub(crate) fn depths_at<const N: usize>(
        &self,
        r: &ReceiverLanes,
        axes: &Axes,
        x: &Lanes<f32>,
        y: &Lanes<f32>,
    ) -> Depths {
        let mut texels = Texels::default();
        for i in 0..N {
            texels.x[i] = floor(affine(r.x[i], axes[0][i], axes[2][i], x[i], y[i]));
            texels.y[i] = floor(affine(r.y[i], axes[1][i], axes[3][i], x[i], y[i]));
        }
        self.depths_in::<N>(r, &texels)
    }

    #[inline(always)]
    fn depths_in<const N: usize>(&self, r: &ReceiverLanes, texels: &Texels) -> Depths {
        let indices = self.texel_indices::<N>(r, texels);
        Depths {
            receiver: self.receiver_depths::<N>(r, texels),
            stored: self.load(&indices, r.count),
        }
    }

    /// Returns the texels under a tap that each receiver shifts by its own shift.
    #[inline(always)]
    fn texels_at_tap<const N: usize>(&self, r: &ReceiverLanes, axes: &Axes, tap: Vec2) -> Texels {
        let mut texels = Texels::default();
        if self.shape == PatternShape::Square {
            for i in 0..N {
                let x = wrapped(tap.x + r.shift[0][i]);
                let y = wrapped(tap.y + r.shift[1][i]);
                texels.x[i] = floor(affine(r.x[i], axes[0][i], axes[2][i], x, y));
                texels.y[i] = floor(affine(r.y[i], axes[1][i], axes[3][i], x, y));
            }
        } else {
            // Discs are turned and not shifted, so their taps never wrap around.
            for i in 0..N {
                texels.x[i] = floor(affine(r.x[i], axes[0][i], axes[2][i], tap.x, tap.y));
                texels.y[i] = floor(affine(r.y[i], axes[1][i], axes[3][i], tap.x, tap.y));
            }
        }
        texels
    }

    /// Returns the index of each texel among all texels of the map; [`NO_TEXEL`] beside the map, unless its edge repeats.
    #[inline(always)]
    fn texel_indices<const N: usize>(&self, r: &ReceiverLanes, texels: &Texels) -> Lanes<u32> {
        let size = self.map.size as u32;
        let last = (self.map.size - 1) as f32;
        // Or-ed onto the index of a texel that had to be clamped to the map.
        let clamped_bits = if self.map.clamped { 0 } else { NO_TEXEL };
        let mut indices = [NO_TEXEL; BATCH];
        for i in 0..N {
            let column = clamp_to(texels.x[i], last);
            let row = clamp_to(texels.y[i], last);
            // `&` and not `&&`, and a mask and not a branch: so that this loop runs in vector lanes.
            let outside_bits = if (column == texels.x[i]) & (row == texels.y[i]) {
                0
            } else {
                clamped_bits
            };
            let index = r.layer_start[i]
                .wrapping_add(whole_to_u32(row).wrapping_mul(size))
                .wrapping_add(whole_to_u32(column));
            indices[i] = index | outside_bits;
        }
        indices
    }

    /// Returns the receivers' own depths at these texels: [`depth_on_plane`](crate::shadow_map::texel_compare::depth_on_plane) in
    /// lanes.
    #[inline(always)]
    fn receiver_depths<const N: usize>(&self, r: &ReceiverLanes, texels: &Texels) -> Lanes<f32> {
        let mut depths = r.depth;
        for i in 0..N {
            let on_plane = if self.follows_plane {
                let right = texels.x[i] + 0.5 - r.x[i];
                let down = texels.y[i] + 0.5 - r.y[i];
                r.depth[i] + r.right[i] * right + r.down[i] * down
            } else {
                r.depth[i]
            };
            depths[i] = if on_plane < r.deepest[i] {
                on_plane
            } else {
                r.deepest[i]
            };
        }
        depths
    }

    /// Returns the depths stored at these indices, for the first `count` lanes; [`OUTSIDE_DEPTH`] where there is no such texel.
    #[inline(always)]
    fn load(&self, indices: &Lanes<u32>, count: usize) -> Lanes<f32> {
        let mut stored = [0.0; BATCH];
        for (stored, &index) in stored.iter_mut().zip(indices).take(count) {
            *stored = self.map.depth(index as usize).unwrap_or(OUTSIDE_DEPTH);
        }
        stored
    }
}

/// The texel under a tap of each receiver: whole numbers, also beside the map.
struct Texels {
    x: Lanes<f32>,
    y: Lanes<f32>,
}

impl Default for Texels {
    #[inline(always)]
    fn default() -> Self {
        Self {
            x: [0.0; BATCH],
            y: [0.0; BATCH],
        }
    }
}

/// Returns `x` clamped to 0..=last, and 0 for NaN.
#[inline(always)]
fn clamp_to(x: f32, last: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < last { x } else { last }
}

/// Returns the whole number at or below `x`. Beyond 2^22, where no map reaches, the result is only near it.
///
/// Adding 1.5 * 2^23 leaves no bits for a fraction, so the sum is rounded to the nearest whole number. `f32::floor` is an
/// instruction that not all processors have, and on those a call, which vector lanes cannot make.
#[inline(always)]
fn floor(x: f32) -> f32 {
    let nearest = (x + 1.5 * TWO_POW_23) - 1.5 * TWO_POW_23;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// Converts a whole number from 0 to [`TWO_POW_23`] to an integer: in lanes, where `as` is not, since it also bounds its result.
#[inline(always)]
fn whole_to_u32(x: f32) -> u32 {
    (x + TWO_POW_23)
        .to_bits()
        .wrapping_sub(TWO_POW_23.to_bits())
}
