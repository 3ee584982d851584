//! The comparison sampler: one lookup compares with four texels and blends the answers by where it lies between them.
//!
//! What samplers do is fixed only in part. The arithmetic here is what Mesa's software driver was measured to do: with
//! c = max(min(u W, W) - .5, 0), x₀ = ⌊c⌋, x₁ = min(x₀ + 1, W - 1), s = c - x₀, and the same for t in y, a row answers
//! (x₁ lit ? s : 0) + (x₀ lit ? 1 - s : 0), and the sample top + t (bottom - top), rounded once. Weights are whole floats
//! there; graphics chips hold them in 8 bits: see [`WEIGHT_ERROR`].

use crate::{
    filtering::bilinear_weights::{BILINEAR_WEIGHTS, reference_depth},
    shadow_map::{coord::ShadowCoord, layers::ShadowMapUniforms, texel_compare::DepthMap},
};
use glam::Vec2;
use umbrage_core::Module;

/// How far a sampler with weights of 8 bits may be from the exact blend: each of two weights is off by less than 1/256,
/// and answers differ by at most 1 along each axis. (7.3e-3 was the most over 786,432 random lookups.) Means of samples
/// are no farther off, since their weights add to 1.
pub const WEIGHT_ERROR: f32 = 2.0 / 256.0;

/// How many samples a side the lanes hold.
pub(crate) const LANES: usize = 4;

const SAMPLED: Module = Module {
    name: "comparison_sampler",
    text: include_str!("comparison_sampler.wgsl"),
};
const CLAMPED: Module = Module {
    name: "choice: samples beside the map read its edge",
    text: "fn sampled(l: ShadowCoord, size: f32, at: vec2f) -> f32 { return sampled_clamped(l, size, at); }\n",
};
const LIT_BORDER: Module = Module {
    name: "choice: samples beside the map are lit",
    text: "fn sampled(l: ShadowCoord, size: f32, at: vec2f) -> f32 { return sampled_lit(l, size, at); }\n",
};

/// Returns the WGSL of `sampled`, after that of the map's lookup.
pub(crate) fn modules(m: &ShadowMapUniforms) -> Vec<Module> {
    let border = if m.clamped != 0 { CLAMPED } else { LIT_BORDER };
    let mut modules = m.modules();
    modules.extend([BILINEAR_WEIGHTS, SAMPLED, border]);
    modules
}

/// Samples along one axis: where they lie, texels from the map's edge, and what they weigh. Lanes after the last weigh 0.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) at: [f32; LANES],
    pub(crate) weight: [f32; LANES],
}

/// Squares of `N` by `N` samples whose neighbours lie about `STRIDE` texels apart.
pub(crate) struct Samples<'a, const N: usize, const STRIDE: usize> {
    pub(crate) map: DepthMap<'a>,
}

/// The two texels that a lookup falls between along one axis, and the weight of the second.
#[derive(Clone, Copy, Default)]
struct Between {
    low: i32,
    high: i32,
    part: f32,
}

#[inline(always)]
fn between(at: f32, size: i32) -> Between {
    let w = size as f32;
    let c = ((at / w * w).min(w) - 0.5).max(0.0);
    let low = c.floor() as i32;
    Between {
        low,
        high: (low + 1).min(size - 1),
        part: c - low as f32,
    }
}

#[inline(always)]
fn row_of(left: bool, right: bool, part: f32) -> f32 {
    (if right { part } else { 0.0 }) + (if left { 1.0 - part } else { 0.0 })
}

impl<const N: usize, const STRIDE: usize> Samples<'_, N, STRIDE> {
    /// The weighted sum of the samples' answers, 0 to the sum of all weights.
    #[inline(always)]
    pub(crate) fn sum(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> f32 {
        self.in_lanes(l, x, y)
            .unwrap_or_else(|| self.one_by_one(l, x, y))
    }

    fn one_by_one(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> f32 {
        let mut lit = 0.0;
        for i in 0..N {
            let mut column = 0.0;
            for j in 0..N {
                column += y.weight[j] * sampled(&self.map, l, Vec2::new(x.at[i], y.at[j]));
            }
            lit += x.weight[i] * column;
        }
        lit
    }

    /// The same with a lane a column; none at the map's edge or where each sample has a depth of its own.
    #[inline(always)]
    fn in_lanes(&self, l: &ShadowCoord, x: &Axis, y: &Axis) -> Option<f32> {
        if N == 1 || l.gradient != Vec2::ZERO || l.depth > 1.0 {
            return None;
        }
        let (texels, first, parts) = (
            self.map.layer(l.layer)?,
            self.first_column(x)?,
            self.parts(x),
        );
        let mut columns = [0.0; LANES];
        for j in 0..N {
            let b = self.inside(y.at[j])?;
            let rows = [b.low, b.high].map(|y| (y * self.map.size + first) as usize);
            let [top, bottom] = [
                row::<STRIDE>(texels, rows[0], l.depth, &parts)?,
                row::<STRIDE>(texels, rows[1], l.depth, &parts)?,
            ];
            for ((column, top), bottom) in columns.iter_mut().zip(top).zip(bottom) {
                *column += y.weight[j] * b.part.mul_add(bottom - top, top);
            }
        }
        let mut lit = 0.0;
        for (weight, column) in x.weight[..N].iter().zip(&columns) {
            lit += weight * column;
        }
        Some(lit)
    }

    #[inline(always)]
    fn parts(&self, x: &Axis) -> [f32; LANES] {
        x.at.map(|at| between(at, self.map.size).part)
    }

    /// The first texel of the first sample, if the others follow it in steps of `STRIDE` and none touches the rim.
    #[inline(always)]
    fn first_column(&self, x: &Axis) -> Option<i32> {
        let first = self.inside(x.at[0])?.low;
        let last = self.inside(x.at[N - 1])?;
        let follows = |i: usize| between(x.at[i], self.map.size).low == first + (STRIDE * i) as i32;
        (last.high == last.low + 1 && (1..N).all(follows)).then_some(first)
    }

    /// Where the sample lies, unless it touches the rim.
    #[inline(always)]
    fn inside(&self, at: f32) -> Option<Between> {
        (at >= 0.5 && at <= self.map.size as f32 - 0.5).then(|| between(at, self.map.size))
    }
}

/// One row's answers for samples `STRIDE` texels apart.
#[inline(always)]
fn row<const STRIDE: usize>(
    texels: &[f32],
    first: usize,
    depth: f32,
    parts: &[f32; LANES],
) -> Option<[f32; LANES]> {
    let window: &[f32; 8] = texels.get(first..)?.first_chunk()?;
    Some(std::array::from_fn(|i| {
        row_of(
            depth <= window[STRIDE * i],
            depth <= window[STRIDE * i + 1],
            parts[i],
        )
    }))
}

/// One sample, at `at` texels from the map's top left corner.
#[inline(always)]
pub(crate) fn sampled(map: &DepthMap<'_>, l: &ShadowCoord, at: Vec2) -> f32 {
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
    let (x, y) = (between(at.x, map.size), between(at.y, map.size));
    let lit = |x: i32, y: i32| depth <= 1.0 && depth <= map.load(x, y, l.layer);
    let row = |y: i32| row_of(lit(x.low, y), lit(x.high, y), x.part);
    let (top, bottom) = (row(y.low), row(y.high));
    y.part.mul_add(bottom - top, top)
}

/// The blend by hand, where the sampler would not know of the lit border.
#[inline(never)]
fn sampled_at_rim(map: &DepthMap<'_>, layer: i32, at: Vec2, depth: f32) -> f32 {
    let c = at - 0.5;
    let first = c.floor();
    let part = c - first;
    let (x, y) = (first.x as i32, first.y as i32);
    let inside = |v: i32| (0..map.size).contains(&v);
    let answer = |x: i32, y: i32| {
        let lit = !inside(x) || !inside(y) || (depth <= 1.0 && depth <= map.load(x, y, layer));
        if lit { 1.0 } else { 0.0 }
    };
    let row = |y: i32| {
        let (left, right) = (answer(x, y), answer(x + 1, y));
        left + (right - left) * part.x
    };
    let (above, below) = (row(y), row(y + 1));
    above + (below - above) * part.y
}

#[cfg(test)]
#[path = "comparison_sampler_tests.rs"]
mod tests;
