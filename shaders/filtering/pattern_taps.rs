//! Comparisons at the taps of a pattern that is laid over an ellipse or a parallelogram of the map.
//! Every filter over a pattern uses them.
//!
//! One vector lane per receiver: all receivers of a batch take their first tap, then all their
//! second. Each lane adds up its taps in the order of the shader's loop, so both halves agree to
//! the bit. Functions with the parameter `N` compute the first `N` lanes.

#![expect(
    clippy::needless_range_loop,
    reason = "one index into many arrays: that is what compilers turn into vector lanes"
)]

use crate::{
    filtering::sample_pattern::{PatternShape, PatternTable, TapSet, affine, noise_index, wrapped},
    lanes::{
        batch::{BATCH, Lanes},
        whole::{floor, whole_to_u32},
    },
    shadow_map::{coord::ShadowCoord, texel_compare::DepthMap},
};
use glam::{UVec2, Vec2, Vec4};
use umbrage_core::{Module, module};

/// The WGSL half. It reads the kernel's first image and table, and needs the map's modules and
/// [`PATTERN`](crate::filtering::sample_pattern::PATTERN).
pub(crate) const PATTERN_TAPS: Module = module!("pattern_taps");

/// The depth that taps outside the map read: farther than any stored depth, so such taps are lit
/// and block nothing.
const OUTSIDE_DEPTH: f32 = 2.0;
/// The texel index of taps outside the map. All its bits are set, so a bitwise or with it gives it
/// again.
const NO_TEXEL: u32 = u32::MAX;
/// Batches with at most this many receivers go through loops of half the width.
pub(crate) const HALF_BATCH: usize = BATCH / 2;

/// How a pixel's noise rotates a disc or shifts a square.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelRotation {
    /// Cosine and sine of the rotation; (1, 0) for squares.
    pub(crate) cos_sin: Vec2,
    /// Shift right and down, 0..2 each; zero for discs.
    pub(crate) shift: Vec2,
}

impl PixelRotation {
    /// Returns the rotation at the pixel `offset` pixels right of `first`.
    ///
    /// `max_turn` is the greatest index into the table's turns: 0 for no rotation, else one less
    /// than a power of two.
    ///
    /// Panics if the table has no turn `max_turn`.
    #[inline(always)]
    pub(crate) fn at(table: &PatternTable, max_turn: u32, first: UVec2, offset: usize) -> Self {
        let x = first.x.wrapping_add(offset as u32);
        let turn = noise_index(x, first.y) & max_turn;
        let row = table.turns[turn as usize];
        Self {
            cos_sin: Vec2::new(row.x, row.y),
            shift: Vec2::new(row.z, row.w),
        }
    }
}

/// The kernels' half axes, `u` and `v`, of up to [`BATCH`] receivers, texels.
#[derive(Clone)]
pub(crate) struct AxisLanes {
    u_x: Lanes<f32>,
    u_y: Lanes<f32>,
    v_x: Lanes<f32>,
    v_y: Lanes<f32>,
}

impl AxisLanes {
    #[inline(always)]
    fn zero() -> Self {
        Self {
            u_x: [0.0; BATCH],
            u_y: [0.0; BATCH],
            v_x: [0.0; BATCH],
            v_y: [0.0; BATCH],
        }
    }

    /// Returns each receiver's half axes times its own factor.
    #[inline(always)]
    pub(crate) fn scaled(&self, factors: &Lanes<f32>) -> Self {
        let mut axes = self.clone();
        for i in 0..BATCH {
            axes.u_x[i] *= factors[i];
            axes.u_y[i] *= factors[i];
            axes.v_x[i] *= factors[i];
            axes.v_y[i] *= factors[i];
        }
        axes
    }
}

/// How a pattern is laid over the map at one receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelPlacement {
    /// Half axes, texels: x and y of the first, then x and y of the second.
    pub(crate) axes: Vec4,
    /// The shift of a square pattern, 0..2; zero for discs.
    pub(crate) shift: Vec2,
}

/// Up to [`BATCH`] receivers, an array for each field. Only the lanes before `count` hold
/// receivers.
#[derive(Clone)]
pub(crate) struct ReceiverLanes {
    /// How many receivers there are.
    pub(crate) count: usize,
    /// [`ShadowCoord::depth`].
    pub(crate) depth: Lanes<f32>,
    /// [`KernelPlacement::axes`].
    pub(crate) axes: AxisLanes,
    /// Each receiver's index in its batch.
    pub(crate) batch_index: Lanes<usize>,
    /// x of [`ShadowCoord::texel`].
    x: Lanes<f32>,
    /// y of [`ShadowCoord::texel`].
    y: Lanes<f32>,
    /// x of [`KernelPlacement::shift`].
    pub(crate) shift_x: Lanes<f32>,
    /// y of [`KernelPlacement::shift`].
    pub(crate) shift_y: Lanes<f32>,
    /// x of [`ShadowCoord::gradient`], per texel right.
    gradient_x: Lanes<f32>,
    /// y of [`ShadowCoord::gradient`], per texel down.
    gradient_y: Lanes<f32>,
    /// [`ShadowCoord::deepest`].
    deepest: Lanes<f32>,
    /// The index of the first texel of the receiver's layer.
    layer_start: Lanes<u32>,
}

impl ReceiverLanes {
    /// Returns lanes without receivers.
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let zero = [0.0; BATCH];
        Self {
            count: 0,
            depth: zero,
            axes: AxisLanes::zero(),
            batch_index: [0; BATCH],
            x: zero,
            y: zero,
            shift_x: zero,
            shift_y: zero,
            gradient_x: zero,
            gradient_y: zero,
            deepest: zero,
            layer_start: [0; BATCH],
        }
    }

    /// Adds a receiver: its place on the map, its index in the batch and the placement of its
    /// kernel. `size` is the map's side, texels.
    ///
    /// Panics if there are [`BATCH`] already.
    #[inline(always)]
    pub(crate) fn push(
        &mut self,
        l: &ShadowCoord,
        batch_index: usize,
        size: i32,
        placement: KernelPlacement,
    ) {
        let i = self.count;
        self.batch_index[i] = batch_index;
        self.layer_start[i] = (l.layer * size * size) as u32;
        self.x[i] = l.texel.x;
        self.y[i] = l.texel.y;
        self.depth[i] = l.depth;
        self.gradient_x[i] = l.gradient.x;
        self.gradient_y[i] = l.gradient.y;
        self.deepest[i] = l.deepest;
        self.shift_x[i] = placement.shift.x;
        self.shift_y[i] = placement.shift.y;
        self.axes.u_x[i] = placement.axes.x;
        self.axes.u_y[i] = placement.axes.y;
        self.axes.v_x[i] = placement.axes.z;
        self.axes.v_y[i] = placement.axes.w;
        self.count += 1;
    }
}

/// The map and the rules by which taps compare with it.
#[derive(Clone, Copy)]
pub(crate) struct Comparisons<'a> {
    pub(crate) map: DepthMap<'a>,
    /// The pattern's shape.
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
    /// Returns how many taps of `set` are lit, per receiver.
    #[inline(always)]
    pub(crate) fn count_lit(&self, r: &ReceiverLanes, set: &TapSet) -> Lanes<i32> {
        if r.count <= HALF_BATCH {
            self.count_lit_lanes::<HALF_BATCH>(r, set)
        } else {
            self.count_lit_lanes::<BATCH>(r, set)
        }
    }

    #[inline(always)]
    fn count_lit_lanes<const N: usize>(&self, r: &ReceiverLanes, set: &TapSet) -> Lanes<i32> {
        let mut lit = [0; BATCH];
        for &tap in &set.taps {
            let texels = self.texels_at_tap::<N>(r, tap.truncate());
            let depths = self.depths_at_texels::<N>(r, &texels);
            for (i, lit) in lit[..N].iter_mut().enumerate() {
                *lit += i32::from(depths.receiver[i] <= depths.stored[i]);
            }
        }
        lit
    }

    /// Returns the depths at one point of the pattern for each receiver: `x` and `y`, -1..1,
    /// already shifted.
    #[inline(always)]
    pub(crate) fn depths_at_point<const N: usize>(
        &self,
        r: &ReceiverLanes,
        axes: &AxisLanes,
        x: &Lanes<f32>,
        y: &Lanes<f32>,
    ) -> Depths {
        let mut texels = TapTexels::default();
        for i in 0..N {
            texels.x[i] = floor(affine(r.x[i], axes.u_x[i], axes.v_x[i], x[i], y[i]));
            texels.y[i] = floor(affine(r.y[i], axes.u_y[i], axes.v_y[i], x[i], y[i]));
        }
        self.depths_at_texels::<N>(r, &texels)
    }

    #[inline(always)]
    fn depths_at_texels<const N: usize>(&self, r: &ReceiverLanes, texels: &TapTexels) -> Depths {
        let indices = self.texel_indices::<N>(r, texels);
        Depths {
            receiver: self.receiver_depths::<N>(r, texels),
            stored: self.load(&indices, r.count),
        }
    }

    /// Returns the texel under a tap for each receiver.
    ///
    /// A square is shifted by the receiver's own shift; a disc is not, so its taps never wrap
    /// around.
    #[inline(always)]
    fn texels_at_tap<const N: usize>(&self, r: &ReceiverLanes, tap: Vec2) -> TapTexels {
        let axes = &r.axes;
        let mut texels = TapTexels::default();
        if self.shape == PatternShape::Square {
            for i in 0..N {
                let x = wrapped(tap.x + r.shift_x[i]);
                let y = wrapped(tap.y + r.shift_y[i]);
                texels.x[i] = floor(affine(r.x[i], axes.u_x[i], axes.v_x[i], x, y));
                texels.y[i] = floor(affine(r.y[i], axes.u_y[i], axes.v_y[i], x, y));
            }
        } else {
            for i in 0..N {
                texels.x[i] = floor(affine(r.x[i], axes.u_x[i], axes.v_x[i], tap.x, tap.y));
                texels.y[i] = floor(affine(r.y[i], axes.u_y[i], axes.v_y[i], tap.x, tap.y));
            }
        }
        texels
    }

    /// Returns the index of each texel among all texels of the map; [`NO_TEXEL`] beside the map,
    /// unless its edge repeats.
    #[inline(always)]
    fn texel_indices<const N: usize>(&self, r: &ReceiverLanes, texels: &TapTexels) -> Lanes<u32> {
        let size = self.map.size as u32;
        let last = (self.map.size - 1) as f32;
        // Or-ed onto the index of a texel beside the map: nothing where its edge repeats.
        let bits_beside_map = if self.map.clamped { 0 } else { NO_TEXEL };
        let mut indices = [NO_TEXEL; BATCH];
        for i in 0..N {
            let column = clamp_to(texels.x[i], last);
            let row = clamp_to(texels.y[i], last);
            // `&` and not `&&`, and a mask and not a branch, so that this loop is vectorised.
            let extra_bits = if (column == texels.x[i]) & (row == texels.y[i]) {
                0
            } else {
                bits_beside_map
            };
            let index = r.layer_start[i]
                .wrapping_add(whole_to_u32(row).wrapping_mul(size))
                .wrapping_add(whole_to_u32(column));
            indices[i] = index | extra_bits;
        }
        indices
    }

    /// Returns the receivers' own depths at these texels:
    /// [`depth_on_plane`](crate::shadow_map::texel_compare::depth_on_plane) in lanes.
    #[inline(always)]
    fn receiver_depths<const N: usize>(&self, r: &ReceiverLanes, texels: &TapTexels) -> Lanes<f32> {
        let mut depths = r.depth;
        for i in 0..N {
            let on_plane = if self.follows_plane {
                let right = texels.x[i] + 0.5 - r.x[i];
                let down = texels.y[i] + 0.5 - r.y[i];
                r.depth[i] + r.gradient_x[i] * right + r.gradient_y[i] * down
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

    /// Returns the depths stored at these indices, for the first `count` lanes; [`OUTSIDE_DEPTH`]
    /// where there is no such texel.
    #[inline(always)]
    fn load(&self, indices: &Lanes<u32>, count: usize) -> Lanes<f32> {
        let mut stored = [0.0; BATCH];
        let lanes = stored.iter_mut().zip(indices).take(count);
        // Two loops: asking in each lane whether the map is packed takes longer than reading it.
        if self.map.packed {
            for (stored, &index) in lanes {
                *stored = self
                    .map
                    .packed_depth(index as usize)
                    .unwrap_or(OUTSIDE_DEPTH);
            }
        } else {
            for (stored, &index) in lanes {
                *stored = self
                    .map
                    .plain_depth(index as usize)
                    .unwrap_or(OUTSIDE_DEPTH);
            }
        }
        stored
    }
}

/// The texel under one tap, per receiver: whole numbers, also beside the map.
struct TapTexels {
    x: Lanes<f32>,
    y: Lanes<f32>,
}

impl Default for TapTexels {
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
