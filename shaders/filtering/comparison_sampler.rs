//! Comparison sampler: one lookup compares with four texels and blends the results bilinearly.
//!
//! Graphics APIs specify samplers only in part. The arithmetic here was measured on Mesa's software
//! driver. Let c = max(min(u W, W) - .5, 0), x₀ = ⌊c⌋, x₁ = min(x₀ + 1, W - 1), s = c - x₀, and
//! likewise t in y. A row returns (x₁ lit ? s : 0) + (x₀ lit ? 1 - s : 0). The sample returns top +
//! t (bottom - top), rounded once. The weights there are 32-bit floats; graphics chips use 8 bits:
//! see [`WEIGHT_ERROR`].

use crate::{
    filtering::bilinear_weights::{BILINEAR_WEIGHTS, reference_depth},
    shadow_map::{coord::ShadowCoord, layers::ShadowMapUniforms, texel_compare::DepthMap},
};
use glam::Vec2;
use umbrage_core::{Kernel, Module, module};

/// Greatest error of a sampler with 8-bit weights compared with the exact blend. Each of two
/// weights has an error below 1/256, and comparisons differ by at most 1 along each axis. (The
/// greatest error over 786,432 random lookups was 7.3e-3.) The bound also holds for means of
/// samples, since their weights add up to 1.
pub const WEIGHT_ERROR: f32 = 2.0 / 256.0;

/// Returns the tolerance, 0..=1, between the two halves of a kernel in addition to rounding. It is
/// more than 0 if the kernel uses the comparison sampler.
pub fn sampler_tolerance(kernel: &dyn Kernel) -> f32 {
    if kernel.compares() { WEIGHT_ERROR } else { 0.0 }
}

/// Maximum number of samples along one side of the square.
pub(crate) const LANES: usize = 4;

/// The WGSL half.
const COMPARISON_SAMPLER: Module = module!("comparison_sampler");

/// Returns the map's modules, followed by the WGSL of `sampled` and the technique's `own`.
pub(crate) fn modules(m: &ShadowMapUniforms, own: Module) -> Vec<Module> {
    m.modules(&[BILINEAR_WEIGHTS, COMPARISON_SAMPLER, own])
}

/// Samples along one axis of a square. Lanes after the last sample have weight 0.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    /// Positions of the samples, texels from the map's left or top edge.
    pub(crate) at: [f32; LANES],
    /// Weights of the samples.
    pub(crate) weight: [f32; LANES],
}

/// Square of `N` by `N` samples, about `STRIDE` texels apart.
///
/// `FOLLOWS_PLANE` is whether the compared depth follows the receiver's plane, so that it differs
/// from sample to sample. It is a constant, because compiling both loops into one function slows
/// them down.
pub(crate) struct Samples<'a, const N: usize, const STRIDE: usize, const FOLLOWS_PLANE: bool> {
    pub(crate) map: DepthMap<'a>,
}

/// Two texels around a sample along one axis, and the weight of the second.
#[derive(Clone, Copy, Default)]
struct TexelPair {
    low: i32,
    high: i32,
    weight: f32,
}

/// Returns the texels around a sample `at` texels from the edge of a map with this side.
#[inline(always)]
fn texel_pair(at: f32, size: i32) -> TexelPair {
    let w = size as f32;
    // Compute `at / w * w` and not `at`: samplers take coordinates from 0 to 1, and the division
    // rounds.
    let c = ((at / w * w).min(w) - 0.5).max(0.0);
    let low = c.floor() as i32;
    TexelPair {
        low,
        high: (low + 1).min(size - 1),
        weight: c - low as f32,
    }
}

/// Returns the blend of two horizontally adjacent comparisons; `weight` is that of the right one.
#[inline(always)]
fn blend_row(left_lit: bool, right_lit: bool, weight: f32) -> f32 {
    let right = if right_lit { weight } else { 0.0 };
    let left = if left_lit { 1.0 - weight } else { 0.0 };
    right + left
}

impl<const N: usize, const STRIDE: usize, const FOLLOWS_PLANE: bool>
    Samples<'_, N, STRIDE, FOLLOWS_PLANE>
{
    /// Returns the weighted sum of the samples, 0 to the sum of all weights.
    #[inline(always)]
    pub(crate) fn sum(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> f32 {
        if FOLLOWS_PLANE || N == 1 {
            return self.one_by_one(l, x, y);
        }
        match self.in_lanes(l, x, y) {
            Some(sum) => sum,
            None => self.one_by_one_apart(l, x, y),
        }
    }

    /// Calls [`one_by_one`](Self::one_by_one) without inlining, for the few lookups at the map's
    /// edge.
    #[inline(never)]
    fn one_by_one_apart(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> f32 {
        self.one_by_one(l, x, y)
    }

    /// Returns the weighted sum, sample by sample in the order of the shader's loop.
    ///
    /// It must be inlined. Compiled separately, it would lack the vector instructions for `floor`
    /// and `mul_add`, and call functions instead.
    #[expect(
        clippy::needless_range_loop,
        reason = "one index into the places, the weights and the texels of an axis"
    )]
    #[inline(always)]
    fn one_by_one(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> f32 {
        let columns = x.at.map(|at| texel_pair(at, self.map.size));
        let rows = y.at.map(|at| texel_pair(at, self.map.size));
        let mut lit = 0.0;
        for i in 0..N {
            let mut column = 0.0;
            for j in 0..N {
                let at = Vec2::new(x.at[i], y.at[j]);
                column += y.weight[j] * sampled_between(&self.map, l, at, columns[i], rows[j]);
            }
            lit += x.weight[i] * column;
        }
        lit
    }

    /// Returns the weighted sum, with a lane for each column of samples; `None` at the map's edge
    /// and if each sample has its own depth.
    #[inline(always)]
    fn in_lanes(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> Option<f32> {
        if l.gradient != Vec2::ZERO || l.depth > 1.0 {
            return None;
        }
        let texels = self.map.layer(l.layer)?;
        let first = self.first_column(x)?;
        let weights = x.at.map(|at| texel_pair(at, self.map.size).weight);
        let mut columns = [0.0; LANES];
        for j in 0..N {
            let rows = self.inner_texel_pair(y.at[j])?;
            let top_start = (rows.low * self.map.size + first) as usize;
            let bottom_start = (rows.high * self.map.size + first) as usize;
            let top = compare_row::<STRIDE>(texels, top_start, l.depth, &weights)?;
            let bottom = compare_row::<STRIDE>(texels, bottom_start, l.depth, &weights)?;
            for ((column, top), bottom) in columns.iter_mut().zip(top).zip(bottom) {
                *column += y.weight[j] * rows.weight.mul_add(bottom - top, top);
            }
        }
        let mut lit = 0.0;
        for (weight, column) in x.weight[..N].iter().zip(&columns) {
            lit += weight * column;
        }
        Some(lit)
    }

    /// Returns the first texel's column of the first sample. Returns `None` unless the other
    /// samples follow in steps of exactly `STRIDE` texels and all are inside the map's border.
    #[inline(always)]
    fn first_column(&self, x: &Axis) -> Option<i32> {
        let first = self.inner_texel_pair(x.at[0])?.low;
        let last = self.inner_texel_pair(x.at[N - 1])?;
        if last.high != last.low + 1 {
            return None;
        }
        // Texel coordinates are rounded, so a sample may be one texel off its expected column.
        for i in 1..N {
            if texel_pair(x.at[i], self.map.size).low != first + (STRIDE * i) as i32 {
                return None;
            }
        }
        Some(first)
    }

    /// Returns the texels of a sample; `None` if it is within half a texel of the map's edge or
    /// outside.
    #[inline(always)]
    fn inner_texel_pair(&self, at: f32) -> Option<TexelPair> {
        if at >= 0.5 && at <= self.map.size as f32 - 0.5 {
            Some(texel_pair(at, self.map.size))
        } else {
            None
        }
    }
}

/// Returns the results of one row for samples `STRIDE` texels apart, starting at the texel with
/// index `first`; `None` if fewer than eight texels are left.
#[inline(always)]
fn compare_row<const STRIDE: usize>(
    texels: &[f32],
    first: usize,
    depth: f32,
    weights: &[f32; LANES],
) -> Option<[f32; LANES]> {
    let window: &[f32; 8] = texels.get(first..)?.first_chunk()?;
    Some(std::array::from_fn(|i| {
        let left_lit = depth <= window[STRIDE * i];
        let right_lit = depth <= window[STRIDE * i + 1];
        blend_row(left_lit, right_lit, weights[i])
    }))
}

/// Returns the result of one sample, 0..=1, at `at` texels from the map's top left corner, between
/// these columns and rows.
#[inline(always)]
fn sampled_between(
    map: &DepthMap<'_>,
    l: &ShadowCoord,
    at: Vec2,
    columns: TexelPair,
    rows: TexelPair,
) -> f32 {
    let depth = reference_depth(
        l.depth,
        l.gradient,
        l.deepest,
        map.sample_gain,
        at - l.texel,
    );
    let last = map.size as f32 - 0.5;
    if !map.clamped && (at.x < 0.5 || at.y < 0.5 || at.x > last || at.y > last) {
        return sampled_at_rim(map, l.layer, at, depth);
    }
    let top_left = is_lit(map, columns.low, rows.low, l.layer, depth);
    let top_right = is_lit(map, columns.high, rows.low, l.layer, depth);
    let bottom_left = is_lit(map, columns.low, rows.high, l.layer, depth);
    let bottom_right = is_lit(map, columns.high, rows.high, l.layer, depth);
    let top = blend_row(top_left, top_right, columns.weight);
    let bottom = blend_row(bottom_left, bottom_right, columns.weight);
    rows.weight.mul_add(bottom - top, top)
}

/// Returns whether a texel of the map leaves `depth` lit. Nothing beyond the far plane is lit,
/// whatever depth is stored.
#[inline(always)]
fn is_lit(map: &DepthMap<'_>, x: i32, y: i32, layer: i32, depth: f32) -> bool {
    depth <= 1.0 && depth <= map.load(x, y, layer)
}

/// Returns the result of a sample that touches the lit border. It is blended explicitly, because
/// WebGPU has no sampler with such a border.
#[inline(never)]
fn sampled_at_rim(map: &DepthMap<'_>, layer: i32, at: Vec2, depth: f32) -> f32 {
    let c = at - 0.5;
    let first = c.floor();
    let weight = c - first;
    let x = first.x as i32;
    let y = first.y as i32;
    let above = rim_row(map, x, y, layer, depth, weight.x);
    let below = rim_row(map, x, y + 1, layer, depth, weight.x);
    above + (below - above) * weight.y
}

/// Returns the blend of the results of texels (x, y) and (x + 1, y).
fn rim_row(map: &DepthMap<'_>, x: i32, y: i32, layer: i32, depth: f32, weight: f32) -> f32 {
    let left = rim_answer(map, x, y, layer, depth);
    let right = rim_answer(map, x + 1, y, layer, depth);
    left + (right - left) * weight
}

/// Returns the result of one texel; 1 outside the map.
fn rim_answer(map: &DepthMap<'_>, x: i32, y: i32, layer: i32, depth: f32) -> f32 {
    if !map.has(x, y) || is_lit(map, x, y, layer, depth) {
        1.0
    } else {
        0.0
    }
}

#[cfg(test)]
#[path = "comparison_sampler_tests.rs"]
mod tests;
