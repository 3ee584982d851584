//! Comparisons at the taps of a pattern, laid over an ellipse or a parallelogram of the map. Shared by what filters over
//! patterns. Counts and sums are whole numbers, which add in any order: so lanes agree with the shader's loop to the bit.

use crate::{
    lookup::{DepthMap, Lookup},
    pattern::{PatternTable, Shape, noise_index, wrapped},
};
use glam::{UVec2, Vec2, Vec4};
use umbrage_core::{Module, Twin, twin};

/// The WGSL half. It reads the kernel's first image and table, and needs the modules `shadow_map` and `pattern`.
pub(crate) const SOFT_TAPS: Module = Module { name: "soft_taps", text: include_str!("soft_taps.wgsl") };

/// What taps outside the map read: farther than any depth, so they are lit and block nothing.
const OUTSIDE: f32 = 2.0;
/// Taps that are followed at once.
pub(crate) const LANES: usize = 8;

/// One set of taps in lanes.
#[derive(Clone, Debug)]
pub(crate) struct LaneTaps {
    pub(crate) count: u32,
    groups: Vec<Group>,
}

#[derive(Clone, Copy, Debug)]
struct Group {
    x: [f32; LANES],
    y: [f32; LANES],
    /// 1 for taps that count, 0 for those that only fill the lanes.
    one: [i32; LANES],
}

impl LaneTaps {
    pub(crate) fn new(taps: &[Vec2]) -> Self {
        let group = |part: &[Vec2]| {
            let lane = |i: usize| part.get(i).copied().unwrap_or(Vec2::ZERO);
            let one = std::array::from_fn(|i| i32::from(i < part.len()));
            Group { x: std::array::from_fn(|i| lane(i).x), y: std::array::from_fn(|i| lane(i).y), one }
        };
        Self { count: taps.len() as u32, groups: taps.chunks(LANES).map(group).collect() }
    }
}

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
    let (x, y) = (wrapped(q.x + shift.x), wrapped(q.y + shift.y));
    Vec2::new(from.x + axes.x * x + axes.z * y, from.y + axes.y * x + axes.w * y)
}

/// A receiver's pattern, laid over the map.
#[derive(Clone, Copy)]
pub(crate) struct Laid<'a> {
    pub(crate) map: DepthMap<'a>,
    pub(crate) l: &'a Lookup,
    /// Half axes in texels: x, y of one, then of the other.
    pub(crate) axes: Vec4,
    pub(crate) shift: Vec2,
    /// Squares are shifted, discs are not.
    pub(crate) shape: Shape,
    /// As [`MapLookup::farthest`](crate::lookup::MapLookup::farthest): taps on the receiver's plane go no farther.
    pub(crate) farthest: f32,
}

/// Of a group of taps: the depths stored there, and the receiver's.
type Depths = ([f32; LANES], [f32; LANES]);

impl Laid<'_> {
    /// How many taps see the receiver lit.
    #[inline(always)]
    pub(crate) fn lit(&self, taps: &LaneTaps) -> i32 {
        let mut lit = [0; LANES];
        for group in &taps.groups {
            let (stored, receiver) = self.depths(group);
            for i in 0..LANES {
                lit[i] += if receiver[i] <= stored[i] { group.one[i] } else { 0 };
            }
        }
        lit.iter().sum()
    }

    /// How many taps see something nearer, and by how much nearer in sum, in steps of 1 / `units` of clip depth; no tap
    /// counts for more than 1.
    #[inline(always)]
    pub(crate) fn blockers(&self, taps: &LaneTaps, units: f32) -> [i32; 2] {
        let (mut count, mut sum) = ([0; LANES], [0; LANES]);
        for group in &taps.groups {
            let (stored, receiver) = self.depths(group);
            for i in 0..LANES {
                let blocks = if receiver[i] <= stored[i] { 0 } else { group.one[i] };
                count[i] += blocks;
                sum[i] += ((receiver[i] - stored[i]).min(1.0) * units) as i32 * blocks;
            }
        }
        [count.iter().sum(), sum.iter().sum()]
    }

    #[inline(always)]
    fn depths(&self, group: &Group) -> Depths {
        let (x, y) = self.texels(group);
        let mut receiver = [0.0; LANES];
        let l = self.l;
        for i in 0..LANES {
            let (right, down) = (x[i] + 0.5 - l.texel.x, y[i] + 0.5 - l.texel.y);
            receiver[i] = (l.depth + l.gradient.x * right + l.gradient.y * down).min(self.farthest);
        }
        (self.load(&self.indices(&x, &y)), receiver)
    }

    /// Where texels lie in a layer; -1 for those outside the map, unless its edge repeats.
    #[inline(always)]
    fn indices(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [i32; LANES] {
        let (size, clamped) = (self.map.size, self.map.clamped);
        let last = (size - 1) as f32;
        let mut index = [-1; LANES];
        for i in 0..LANES {
            let (column, row) = (x[i].max(0.0).min(last), y[i].max(0.0).min(last));
            let inside = clamped | ((column == x[i]) & (row == y[i]));
            let at = row as i32 * size + column as i32;
            index[i] = if inside { at } else { -1 };
        }
        index
    }

    /// Texels under the taps, whole numbers.
    #[inline(always)]
    fn texels(&self, group: &Group) -> Depths {
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        let (a, texel) = (self.axes, self.l.texel);
        if self.shape == Shape::Square {
            for i in 0..LANES {
                let place = tap_place(texel, a, Vec2::new(group.x[i], group.y[i]), self.shift);
                (x[i], y[i]) = (place.x.floor(), place.y.floor());
            }
        } else {
            // Nothing wraps where nothing is shifted.
            for i in 0..LANES {
                x[i] = (texel.x + a.x * group.x[i] + a.z * group.y[i]).floor();
                y[i] = (texel.y + a.y * group.x[i] + a.w * group.y[i]).floor();
            }
        }
        (x, y)
    }

    #[inline(always)]
    fn load(&self, index: &[i32; LANES]) -> [f32; LANES] {
        let (map, size) = (self.map, self.map.size);
        if let Some(texels) = map.layer(self.l.layer) {
            return index.map(|i| texels.get(i as usize).copied().unwrap_or(OUTSIDE));
        }
        index.map(|i| if i < 0 { OUTSIDE } else { map.load(i % size, i / size, self.l.layer) })
    }
}

/// The pairs, for the lockstep tests.
pub(crate) const TWINS: &[Twin] =
    &[twin!(PLACED, tap_place(from: Vec2, axes: Vec4, q: Vec2, shift: Vec2) -> Vec2, needs [crate::pattern::PATTERN])];

/// The part of [`SOFT_TAPS`] that reads nothing.
pub(crate) const PLACED: Module = Module { name: "tap_place", text: include_str!("tap_place.wgsl") };
