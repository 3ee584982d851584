//! Comparisons at the taps of a pattern, placement over an ellipse or a parallelogram of the map. Shared by what filters over
//! patterns. ReceiverLanes are the lanes: all of a batch go to their first tap, then all to their second. Each lane adds up in the
//! order of the shader's loop, so both agree to the bit.

use crate::{
    filtering::sample_pattern::{PatternShape, PatternTable, TapSet, noise_index, wrapped},
    lanes::batch::{BATCH, Batch},
    shadow_map::{coord::ShadowCoord, texel_compare::DepthMap},
};
use glam::{UVec2, Vec2, Vec4};
use umbrage_core::{Module, Twin, twin};

/// The WGSL half. It reads the kernel's first image and table, and needs the modules `lookup` and `pattern`.
pub(crate) const PATTERN_TAPS: Module = Module {
    name: "pattern_taps",
    text: include_str!("pattern_taps.wgsl"),
};

/// What taps outside the map read: farther than any depth, so they are lit and block nothing.
const OUTSIDE: f32 = 2.0;
/// The index of taps outside the map.
const NOWHERE: u32 = u32::MAX;
/// 2^23: floats from here on are whole, and the bits below the exponent count from it.
const WHOLE: f32 = 8_388_608.0;
/// Batches at most this full are followed half as wide.
pub(crate) const HALF: usize = BATCH / 2;

/// The pattern's turn at a pixel: (cos, sin, shift x, shift y). `mask` is 0 to turn it nowhere, else one less than the
/// number of turns.
#[inline(always)]
pub(crate) fn turn_at(table: &PatternTable, mask: u32, first: UVec2, offset: usize) -> Vec4 {
    table.turns[(noise_index(first.x.wrapping_add(offset as u32), first.y) & mask) as usize]
}

/// A tap's place, texels, for a receiver at `from`. The sum goes from left to right: with the offset in parentheses, a
/// driver was seen to add in another order.
#[inline(always)]
pub(crate) fn tap_place(from: Vec2, axes: Vec4, q: Vec2, shift: Vec2) -> Vec2 {
    place(
        from,
        axes,
        Vec2::new(wrapped(q.x + shift.x), wrapped(q.y + shift.y)),
    )
}

/// The same for a tap that is not shifted.
#[inline(always)]
pub(crate) fn place(from: Vec2, axes: Vec4, q: Vec2) -> Vec2 {
    Vec2::new(
        placed(from.x, axes.x, axes.z, [q.x, q.y]),
        placed(from.y, axes.y, axes.w, [q.x, q.y]),
    )
}

/// One coordinate of [`place`].
#[inline(always)]
pub(crate) fn placed(from: f32, a: f32, b: f32, [x, y]: [f32; 2]) -> f32 {
    from + a * x + b * y
}

/// A field of many receivers.
pub(crate) type Lanes<T> = [T; BATCH];
/// Half axes in texels: x, y of one, then of the other.
pub(crate) type Axes = [Lanes<f32>; 4];

/// How a pattern lies over the map at one receiver.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KernelPlacement {
    /// Half axes in texels: x, y of one, then of the other.
    pub(crate) axes: Vec4,
    pub(crate) shift: Vec2,
    /// What belongs to the receiver besides, for whoever placement it.
    pub(crate) more: [f32; MORE],
}

/// Numbers of [`KernelPlacement::more`].
pub(crate) const MORE: usize = 6;

/// ReceiverLanes in lanes, an array a field. Lanes from `count` on hold anything.
#[derive(Clone)]
pub(crate) struct ReceiverLanes {
    pub(crate) count: usize,
    pub(crate) depth: Lanes<f32>,
    pub(crate) axes: Axes,
    /// [`KernelPlacement::more`].
    pub(crate) more: [Lanes<f32>; MORE],
    /// Each one's number in its batch.
    pub(crate) number: Lanes<usize>,
    pub(crate) x: Lanes<f32>,
    pub(crate) y: Lanes<f32>,
    pub(crate) shift: [Lanes<f32>; 2],
    right: Lanes<f32>,
    down: Lanes<f32>,
    deepest: Lanes<f32>,
    /// Where its layer begins, texels.
    layer: Lanes<u32>,
}

impl ReceiverLanes {
    /// Those of a batch's first `count` that the map sees and for which `placement` places the pattern.
    #[inline(always)]
    pub(crate) fn seen(
        batch: &Batch,
        count: usize,
        size: i32,
        mut placement: impl FnMut(&ShadowCoord, usize) -> Option<KernelPlacement>,
    ) -> Self {
        let zero = [0.0; BATCH];
        let mut r = Self {
            count: 0,
            depth: zero,
            axes: [zero; 4],
            more: [zero; MORE],
            number: [0; BATCH],
            x: zero,
            y: zero,
            right: zero,
            down: zero,
            deepest: zero,
            shift: [zero; 2],
            layer: [0; BATCH],
        };
        for number in 0..count.min(BATCH) {
            let l = batch.lookup(number);
            if l.seen
                && let Some(placement) = placement(&l, number)
            {
                r.push(&l, number, size, placement);
            }
        }
        r
    }

    #[inline(always)]
    fn push(&mut self, l: &ShadowCoord, number: usize, size: i32, placement: KernelPlacement) {
        let i = self.count;
        (self.number[i], self.layer[i]) = (number, (l.layer * size * size) as u32);
        (self.x[i], self.y[i], self.depth[i]) = (l.texel.x, l.texel.y, l.depth);
        (self.right[i], self.down[i], self.deepest[i]) = (l.gradient.x, l.gradient.y, l.deepest);
        (self.shift[0][i], self.shift[1][i]) = (placement.shift.x, placement.shift.y);
        [
            self.axes[0][i],
            self.axes[1][i],
            self.axes[2][i],
            self.axes[3][i],
        ] = placement.axes.to_array();
        for (lanes, more) in self.more.iter_mut().zip(placement.more) {
            lanes[i] = more;
        }
        self.count += 1;
    }

    /// Each one's axes times what belongs to it.
    #[inline(always)]
    pub(crate) fn scaled(&self, by: &Lanes<f32>) -> Axes {
        let mut axes = self.axes;
        for axis in &mut axes {
            for i in 0..BATCH {
                axis[i] *= by[i];
            }
        }
        axes
    }
}

/// Where comparisons are made.
#[derive(Clone, Copy)]
pub(crate) struct Comparisons<'a> {
    pub(crate) map: DepthMap<'a>,
    /// Squares are shifted, discs are not.
    pub(crate) shape: PatternShape,
    /// Whether receivers' depths differ from tap to tap.
    pub(crate) plane: bool,
}

/// Of the receivers at one tap: the depths stored there, and their own.
pub(crate) struct Depths {
    pub(crate) stored: Lanes<f32>,
    pub(crate) receiver: Lanes<f32>,
}

impl Comparisons<'_> {
    /// How many taps see each receiver lit.
    #[inline(always)]
    pub(crate) fn lit(&self, r: &ReceiverLanes, axes: &Axes, set: &TapSet) -> Lanes<i32> {
        if r.count <= HALF {
            self.lit_in::<HALF>(r, axes, set)
        } else {
            self.lit_in::<BATCH>(r, axes, set)
        }
    }

    #[inline(always)]
    fn lit_in<const N: usize>(&self, r: &ReceiverLanes, axes: &Axes, set: &TapSet) -> Lanes<i32> {
        let mut lit = [0; BATCH];
        for &tap in &set.taps {
            let d = self.depths::<N>(r, axes, tap.truncate());
            for (i, lit) in lit[..N].iter_mut().enumerate() {
                *lit += i32::from(d.receiver[i] <= d.stored[i]);
            }
        }
        lit
    }

    #[inline(always)]
    fn depths<const N: usize>(&self, r: &ReceiverLanes, axes: &Axes, tap: Vec2) -> Depths {
        self.depths_in::<N>(r, self.texels::<N>(r, axes, tap))
    }

    /// At places in texels.
    #[inline(always)]
    pub(crate) fn depths_at<const N: usize>(
        &self,
        r: &ReceiverLanes,
        axes: &Axes,
        q: [&Lanes<f32>; 2],
    ) -> Depths {
        let (mut x, mut y) = ([0.0; BATCH], [0.0; BATCH]);
        for i in 0..N {
            x[i] = floor(placed(r.x[i], axes[0][i], axes[2][i], [q[0][i], q[1][i]]));
            y[i] = floor(placed(r.y[i], axes[1][i], axes[3][i], [q[0][i], q[1][i]]));
        }
        self.depths_in::<N>(r, [x, y])
    }

    #[inline(always)]
    fn depths_in<const N: usize>(&self, r: &ReceiverLanes, texels: [Lanes<f32>; 2]) -> Depths {
        let index = self.indices::<N>(r, &texels);
        Depths {
            receiver: self.receivers::<N>(r, &texels),
            stored: self.load(&index, r.count),
        }
    }

    /// Texels under a tap, whole numbers.
    #[inline(always)]
    fn texels<const N: usize>(&self, r: &ReceiverLanes, a: &Axes, tap: Vec2) -> [Lanes<f32>; 2] {
        let (mut x, mut y) = ([0.0; BATCH], [0.0; BATCH]);
        if self.shape == PatternShape::Square {
            for i in 0..N {
                let q = [
                    wrapped(tap.x + r.shift[0][i]),
                    wrapped(tap.y + r.shift[1][i]),
                ];
                x[i] = floor(placed(r.x[i], a[0][i], a[2][i], q));
                y[i] = floor(placed(r.y[i], a[1][i], a[3][i], q));
            }
        } else {
            // Nothing wraps where nothing is shifted.
            for i in 0..N {
                x[i] = floor(placed(r.x[i], a[0][i], a[2][i], [tap.x, tap.y]));
                y[i] = floor(placed(r.y[i], a[1][i], a[3][i], [tap.x, tap.y]));
            }
        }
        [x, y]
    }

    /// Where texels lie in the map, in texels.
    #[inline(always)]
    fn indices<const N: usize>(&self, r: &ReceiverLanes, [x, y]: &[Lanes<f32>; 2]) -> Lanes<u32> {
        let (size, last) = (self.map.size as u32, (self.map.size - 1) as f32);
        let anywhere = if self.map.clamped { 0 } else { NOWHERE };
        let mut index = [NOWHERE; BATCH];
        for i in 0..N {
            let (column, row) = (within(x[i], last), within(y[i], last));
            let outside = if (column == x[i]) & (row == y[i]) {
                0
            } else {
                anywhere
            };
            let at = r.layer[i]
                .wrapping_add(whole(row).wrapping_mul(size))
                .wrapping_add(whole(column));
            index[i] = at | outside;
        }
        index
    }

    /// ReceiverLanes' depths at a tap's texels.
    #[inline(always)]
    fn receivers<const N: usize>(&self, r: &ReceiverLanes, [x, y]: &[Lanes<f32>; 2]) -> Lanes<f32> {
        let mut depth = r.depth;
        for i in 0..N {
            let bent = if self.plane {
                let (right, down) = (x[i] + 0.5 - r.x[i], y[i] + 0.5 - r.y[i]);
                r.depth[i] + r.right[i] * right + r.down[i] * down
            } else {
                r.depth[i]
            };
            depth[i] = if bent < r.deepest[i] {
                bent
            } else {
                r.deepest[i]
            };
        }
        depth
    }

    #[inline(always)]
    fn load(&self, index: &Lanes<u32>, count: usize) -> Lanes<f32> {
        let mut stored = [0.0; BATCH];
        for (stored, &index) in stored.iter_mut().zip(index).take(count) {
            *stored = self.map.depth(index as usize).unwrap_or(OUTSIDE);
        }
        stored
    }
}

/// Into 0..=last; NaN to 0.
#[inline(always)]
fn within(x: f32, last: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < last { x } else { last }
}

/// The whole number below; beyond 2^22, where no map reaches, only near it. Without an instruction that not all processors
/// have: for those, the standard one is a call.
#[inline(always)]
fn floor(x: f32) -> f32 {
    let nearest = (x + 1.5 * WHOLE) - 1.5 * WHOLE;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// A whole number from 0 to [`WHOLE`] as an integer: what a conversion would give, but in lanes.
#[inline(always)]
fn whole(x: f32) -> u32 {
    (x + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits())
}

/// The pairs, for the lockstep tests.
pub(crate) const TWINS: &[Twin] = &[
    twin!(PLACED, place(from: Vec2, axes: Vec4, q: Vec2) -> Vec2, needs [crate::filtering::sample_pattern::PATTERN]),
    twin!(PLACED, tap_place(from: Vec2, axes: Vec4, q: Vec2, shift: Vec2) -> Vec2, needs [crate::filtering::sample_pattern::PATTERN]),
];

/// The part of [`PATTERN_TAPS`] that reads nothing.
pub(crate) const PLACED: Module = Module {
    name: "tap_place",
    text: include_str!("tap_place.wgsl"),
};
