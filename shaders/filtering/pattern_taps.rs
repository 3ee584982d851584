//! Comparisons at the taps of a pattern that covers an ellipse or a parallelogram of the map. Every
//! filter with a pattern uses them.
//!
//! There is one vector lane per receiver. All receivers of a batch take their first tap, then all
//! take their second. Each lane adds its taps in the order of the shader's loop, so both halves
//! agree bit for bit. Functions with the parameter `N` compute the first `N` lanes.

#![expect(
    clippy::needless_range_loop,
    reason = "compilers vectorise one index into many arrays"
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
use umbrage_core::{Module, math::lesser, module};

/// The WGSL half. It reads the kernel's first image and table, and needs the map's modules and
/// [`PATTERN`](crate::filtering::sample_pattern::PATTERN).
pub(crate) const PATTERN_TAPS: Module = module!("pattern_taps");

/// Depth that taps outside the map read. It is farther than any stored depth, so such taps are lit
/// and block nothing.
const OUTSIDE_DEPTH: f32 = 2.0;
/// Texel index of taps outside the map. All its bits are set, so a bitwise or with it returns it.
const NO_TEXEL: u32 = u32::MAX;
/// Maximum number of receivers for which loops of half the width are used.
pub(crate) const HALF_BATCH: usize = BATCH / 2;

/// Rotation of a disc or shift of a square by a pixel's noise.
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
    /// `max_turn` is the greatest index into the table's turns: 0 for no rotation, otherwise a
    /// power of two minus one.
    ///
    /// Panics if the table has no turn `max_turn`.
    #[inline(always)]
    pub(crate) fn rotation_at(
        table: &PatternTable,
        max_turn: u32,
        first: UVec2,
        offset: usize,
    ) -> Self {
        let x = first.x.wrapping_add(offset as u32);
        let turn = noise_index(x, first.y) & max_turn;
        let row = table.turns[turn as usize];
        Self {
            cos_sin: Vec2::new(row.x, row.y),
            shift: Vec2::new(row.z, row.w),
        }
    }
}

/// Half axes, `u` and `v`, of the kernels of up to [`BATCH`] receivers, texels.
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
    pub(crate) fn scaled_axes(&self, factors: &Lanes<f32>) -> Self {
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

/// Placement of a pattern on the map for one receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelPlacement {
    /// Half axes, texels: x and y of the first, then x and y of the second.
    pub(crate) axes: Vec4,
    /// Shift of a square pattern, 0..2; zero for discs.
    pub(crate) shift: Vec2,
}

/// Up to [`BATCH`] receivers, with an array for each field. Only the lanes before `count` hold
/// receivers.
#[derive(Clone)]
pub(crate) struct ReceiverLanes {
    /// Number of receivers.
    pub(crate) count: usize,
    /// Value of [`ShadowCoord::depth`].
    pub(crate) depth: Lanes<f32>,
    /// Value of [`KernelPlacement::axes`].
    pub(crate) axes: AxisLanes,
    /// Index of each receiver in its batch.
    pub(crate) batch_index: Lanes<usize>,
    /// Texel coordinate x: see [`ShadowCoord::texel`].
    x: Lanes<f32>,
    /// Texel coordinate y: see [`ShadowCoord::texel`].
    y: Lanes<f32>,
    /// Shift right: see [`KernelPlacement::shift`].
    pub(crate) shift_x: Lanes<f32>,
    /// Shift down: see [`KernelPlacement::shift`].
    pub(crate) shift_y: Lanes<f32>,
    /// Depth change per texel right: see [`ShadowCoord::gradient`].
    gradient_x: Lanes<f32>,
    /// Depth change per texel down: see [`ShadowCoord::gradient`].
    gradient_y: Lanes<f32>,
    /// Value of [`ShadowCoord::deepest`].
    deepest: Lanes<f32>,
    /// Index of the first texel of the receiver's layer.
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

    /// Adds a receiver: its map coordinates, its index in the batch and the placement of its
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

    /// Returns [`ShadowCoord::own_depth`] of a receiver.
    #[inline(always)]
    pub(crate) fn own_depth(&self, i: usize) -> f32 {
        lesser(self.depth[i], self.deepest[i])
    }
}

/// Map and comparison settings of taps.
#[derive(Clone, Copy)]
pub(crate) struct Comparisons<'a> {
    pub(crate) map: DepthMap<'a>,
    /// The pattern's shape.
    pub(crate) shape: PatternShape,
    /// True if the compared depth follows the receiver's plane, so that it differs from tap to tap.
    pub(crate) follows_plane: bool,
}

/// Depths of many receivers at one tap each.
pub(crate) struct Depths {
    /// Depth stored in the map, or [`OUTSIDE_DEPTH`].
    pub(crate) stored: Lanes<f32>,
    /// Depth of the receiver at the tap.
    pub(crate) receiver: Lanes<f32>,
}

impl Comparisons<'_> {
    /// Returns the number of lit taps of `set` for each receiver.
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

    /// Returns the depths at one point of the pattern for each receiver. `x` and `y`, -1..1, are
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
    /// Squares are shifted by the receiver's own shift. Discs are not shifted, so their taps never
    /// wrap around.
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

    /// Returns the index of each texel among all texels of the map; [`NO_TEXEL`] outside the map,
    /// unless its edge repeats.
    #[inline(always)]
    fn texel_indices<const N: usize>(&self, r: &ReceiverLanes, texels: &TapTexels) -> Lanes<u32> {
        let size = self.map.size as u32;
        let last = (self.map.size - 1) as f32;
        // Bits to or onto the index of a texel outside the map; zero if the edge repeats.
        let bits_outside_map = if self.map.clamped { 0 } else { NO_TEXEL };
        let mut indices = [NO_TEXEL; BATCH];
        for i in 0..N {
            let column = clamp_to(texels.x[i], last);
            let row = clamp_to(texels.y[i], last);
            // Use `&` and not `&&`, and a mask and not a branch, so that this loop is vectorised.
            let extra_bits = if (column == texels.x[i]) & (row == texels.y[i]) {
                0
            } else {
                bits_outside_map
            };
            let index = r.layer_start[i]
                .wrapping_add(whole_to_u32(row).wrapping_mul(size))
                .wrapping_add(whole_to_u32(column));
            indices[i] = index | extra_bits;
        }
        indices
    }

    /// Returns the receivers' depths at these texels. Vectorised
    /// [`depth_on_plane`](crate::shadow_map::texel_compare::depth_on_plane).
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
    /// if there is no such texel.
    #[inline(always)]
    fn load(&self, indices: &Lanes<u32>, count: usize) -> Lanes<f32> {
        let mut stored = [0.0; BATCH];
        let lanes = stored.iter_mut().zip(indices).take(count);
        // Use two loops: testing in each lane whether the map is packed costs more than the load.
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

/// Texel under one tap for each receiver, integer-valued, possibly outside the map.
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
