//! Lookups of many receivers: projecting is arithmetic and runs in vector lanes over batches, tapping is memory and
//! follows one receiver at a time. The arithmetic is `shadow_coord`'s, spelled in scalars so that the compiler finds its lanes.

use crate::{
    lanes::plane::gradient,
    shadow_map::lookup::{ShadowCoord, ShadowMapUniforms, shadow_coord, slope_bias, to_light},
};
use glam::{Mat4, Vec2, Vec3};
use umbrage_core::{Simd, SimdTask, Span, math::dot3};

/// How many receivers are projected before the taps begin.
pub const BATCH: usize = 64;

/// What a technique makes of one lookup. A trait and not a closure, since a method can insist on being inlined into the
/// loop that is compiled for vector instructions: mark it `#[inline(always)]`.
pub trait Taps {
    /// Visibility 0..=1; `offset` is the pixel's place in the span.
    fn visibility(&self, l: &ShadowCoord, offset: usize) -> f32;
}

/// What a technique makes of a batch of lookups: all that has [`Taps`] follows one at a time.
pub trait BatchTaps {
    /// Visibilities 0..=1, as many as `out` holds; `first` is the first pixel's place in the span.
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]);
}

impl<T: Taps> BatchTaps for T {
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            let l = batch.lookup(i);
            *out = if l.seen {
                self.visibility(&l, first + i)
            } else {
                1.0
            };
        }
    }
}

/// Looks up a span of receivers in the map of `m`, and fills `out`, as long as the span, with what `taps` makes of them.
/// Receivers that the map can say nothing of ([`ShadowCoord::seen`]) are lit.
#[inline]
pub fn look_up_span(
    simd: Simd,
    m: &ShadowMapUniforms,
    span: &Span<'_>,
    out: &mut [f32],
    taps: &impl BatchTaps,
) {
    // The offset along the normal projects twice, a cube has six matrices: they stay with the plain function.
    let (plain, plane) = (
        m.normal_offset != 0.0 || m.layers > 1,
        m.receiver_plane > 0.0,
    );
    match (plain, m.light.w == 0.0, plane) {
        (true, ..) => simd.run_task(LookUpSpan::<_, PLAIN> { m, span, out, taps }),
        (_, true, false) => simd.run_task(LookUpSpan::<_, DISTANT> { m, span, out, taps }),
        (_, false, false) => simd.run_task(LookUpSpan::<_, NEAR> { m, span, out, taps }),
        (_, true, true) => simd.run_task(LookUpSpan::<_, DISTANT_PLANE> { m, span, out, taps }),
        (_, false, true) => simd.run_task(LookUpSpan::<_, NEAR_PLANE> { m, span, out, taps }),
    }
}

/// Ways to project.
const PLAIN: u8 = 0;
const DISTANT: u8 = 1;
const NEAR: u8 = 2;
/// With the receiver's plane.
const DISTANT_PLANE: u8 = 3;
const NEAR_PLANE: u8 = 4;

struct LookUpSpan<'a, T, const WAY: u8> {
    m: &'a ShadowMapUniforms,
    span: &'a Span<'a>,
    out: &'a mut [f32],
    taps: &'a T,
}

/// The places on the map of up to [`BATCH`] receivers, an array a field.
#[derive(Clone, Debug)]
pub struct Batch {
    x: [f32; BATCH],
    y: [f32; BATCH],
    depth: [f32; BATCH],
    right: [f32; BATCH],
    down: [f32; BATCH],
    /// [`ShadowMapUniforms::deepest_tap`].
    deepest_tap: f32,
    layer: [i32; BATCH],
    seen: [bool; BATCH],
}

impl Batch {
    /// Returns the place on the map of receiver `i` of the batch.
    #[inline(always)]
    pub fn lookup(&self, i: usize) -> ShadowCoord {
        let (texel, gradient) = (
            Vec2::new(self.x[i], self.y[i]),
            Vec2::new(self.right[i], self.down[i]),
        );
        let depth = self.depth[i];
        let deepest = depth.max(self.deepest_tap);
        ShadowCoord {
            texel,
            depth,
            gradient,
            deepest,
            layer: self.layer[i],
            seen: self.seen[i],
        }
    }
}

impl<T: BatchTaps, const WAY: u8> SimdTask for LookUpSpan<'_, T, WAY> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { m, span, out, taps } = self;
        let zero = [0.0; BATCH];
        let mut b = Batch {
            x: zero,
            y: zero,
            depth: zero,
            right: zero,
            down: zero,
            deepest_tap: m.deepest_tap,
            layer: [0; BATCH],
            seen: [false; BATCH],
        };
        for first in (0..out.len()).step_by(BATCH) {
            let count = BATCH.min(out.len() - first);
            match WAY {
                PLAIN => one_by_one(m, span, first, count, &mut b),
                DISTANT => in_lanes::<false, false>(m, span, first, count, &mut b),
                NEAR => in_lanes::<true, false>(m, span, first, count, &mut b),
                DISTANT_PLANE => in_lanes::<false, true>(m, span, first, count, &mut b),
                _ => in_lanes::<true, true>(m, span, first, count, &mut b),
            }
            taps.visibilities(&b, first, &mut out[first..first + count]);
        }
    }
}

#[inline(always)]
fn one_by_one(m: &ShadowMapUniforms, span: &Span<'_>, first: usize, count: usize, b: &mut Batch) {
    for i in 0..count {
        let l = shadow_coord(m, span.position(first + i), span.normal(first + i));
        (b.x[i], b.y[i], b.depth[i]) = (l.texel.x, l.texel.y, l.depth);
        (b.right[i], b.down[i]) = (l.gradient.x, l.gradient.y);
        (b.layer[i], b.seen[i]) = (l.layer, l.seen);
    }
}

/// A row of the matrix times a point, from left to right.
#[inline(always)]
fn row(m: &Mat4, i: usize, p: Vec3) -> f32 {
    let [x, y, z, w] = [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.w_axis[i]];
    x * p.x + y * p.y + z * p.z + w
}

#[inline(always)]
#[expect(clippy::manual_clamp, reason = "as in `texel_from_clip`")]
fn in_lanes<const LOCAL: bool, const PLANE: bool>(
    m: &ShadowMapUniforms,
    span: &Span<'_>,
    first: usize,
    count: usize,
    b: &mut Batch,
) {
    let part = |values: &[f32]| -> [f32; BATCH] {
        let mut out = [0.0; BATCH];
        out[..count].copy_from_slice(&values[first..first + count]);
        out
    };
    let (x, y, z) = (part(span.x), part(span.y), part(span.z));
    let (nx, ny, nz) = (part(span.nx), part(span.ny), part(span.nz));
    let (matrix, size) = (m.faces[0], m.size);
    // A light without a position has one direction for all.
    let towards = m.light.truncate();
    let mut clip = [[0.0; BATCH]; 3];
    for i in 0..BATCH {
        let (p, n) = (Vec3::new(x[i], y[i], z[i]), Vec3::new(nx[i], ny[i], nz[i]));
        let l = if LOCAL { to_light(m.light, p) } else { towards };
        let bias = m.constant + slope_bias(m.slope, m.slope_min, dot3(n, l));
        let w = row(&matrix, 3, p);
        let (u, v, d) = (
            row(&matrix, 0, p) / w,
            row(&matrix, 1, p) / w,
            row(&matrix, 2, p) / w,
        );
        b.x[i] = ((u * 0.5 + 0.5) * size).min(1e6).max(-1e6);
        b.y[i] = ((0.5 - v * 0.5) * size).min(1e6).max(-1e6);
        b.depth[i] = d - bias;
        b.seen[i] = w > 0.0 && d <= m.farthest;
        clip[0][i] = u;
        clip[1][i] = v;
        clip[2][i] = d;
    }
    if PLANE {
        planes(m, &clip, &[nx, ny, nz], b);
    }
}

/// The receivers' planes, in a loop of their own: with the rest of the arithmetic the compiler loses sight of its lanes.
#[inline(always)]
fn planes(
    m: &ShadowMapUniforms,
    clip: &[[f32; BATCH]; 3],
    normal: &[[f32; BATCH]; 3],
    b: &mut Batch,
) {
    let (columns, size, limit) = (m.faces[0].to_cols_array_2d(), m.size, m.receiver_plane);
    let (mut right, mut down) = ([0.0; BATCH], [0.0; BATCH]);
    for i in 0..BATCH {
        let at = |field: &[[f32; BATCH]; 3]| [field[0][i], field[1][i], field[2][i]];
        let g = gradient(&columns, at(clip), at(normal), size, limit);
        right[i] = g.x;
        down[i] = g.y;
    }
    (b.right, b.down) = (right, down);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec4, dcamera::rh::proj::directx};

    fn lookup(light: Vec4, slope: f32, receiver_plane: f32) -> ShadowMapUniforms {
        let clip_from_world = directx::perspective(1.2, 1.0, 0.3, 40.0).as_mat4();
        let texel = 0.01;
        let (constant, slope_min, normal_offset) = (1e-3, slope * 0.1, 0.0);
        ShadowMapUniforms {
            faces: [clip_from_world; 6],
            light,
            layers: 1,
            packed: 0,
            clamped: 0,
            farthest: 1.0,
            size: 300.0,
            texel,
            has_receiver_bias: u32::from(slope != 0.0),
            constant,
            slope,
            slope_min,
            normal_offset,
            receiver_plane,
            deepest_tap: 1.0,
            sample_gain: 1.0,
        }
    }

    struct Check<'a> {
        m: &'a ShadowMapUniforms,
        span: &'a Span<'a>,
    }

    impl Taps for Check<'_> {
        fn visibility(&self, l: &ShadowCoord, i: usize) -> f32 {
            let plain = shadow_coord(self.m, self.span.position(i), self.span.normal(i));
            assert_eq!(
                l.texel.to_array().map(f32::to_bits),
                plain.texel.to_array().map(f32::to_bits),
                "{i}"
            );
            assert_eq!(
                l.gradient.to_array().map(f32::to_bits),
                plain.gradient.to_array().map(f32::to_bits),
                "{i}"
            );
            assert_eq!(
                (l.depth.to_bits(), l.seen),
                (plain.depth.to_bits(), plain.seen),
                "{i}"
            );
            assert_eq!(l.deepest.to_bits(), plain.deepest.to_bits(), "{i}");
            0.5
        }
    }

    /// Lanes and the plain function, over points before, behind and beside the light.
    #[test]
    fn lanes_equal_the_plain_function() {
        let wave = |k: f32, scale: f32| {
            (0..200)
                .map(|i| (i as f32 * k).sin() * scale)
                .collect::<Vec<f32>>()
        };
        let (x, y, z) = (wave(0.7, 20.0), wave(1.3, 20.0), wave(2.3, 50.0));
        let (nx, ny, nz) = (wave(0.31, 0.5), wave(0.57, 0.5), wave(0.9, 0.5));
        let triangle = vec![0; 200];
        let first = glam::UVec2::ZERO;
        let span = Span {
            first,
            x: &x,
            y: &y,
            z: &z,
            nx: &nx,
            ny: &ny,
            nz: &nz,
            triangle: &triangle,
        };
        let (sun, lamp) = (Vec4::new(0.0, 1.0, 0.0, 0.0), Vec4::new(1.0, 4.0, 2.0, 1.0));
        for (light, slope, plane) in [
            (sun, 0.05, 0.0),
            (lamp, 0.05, 0.0),
            (Vec4::W, 0.0, 0.0),
            (sun, 0.0, 0.1),
            (lamp, 0.05, 1e-4),
        ] {
            let m = lookup(light, slope, plane);
            let check = Check { m: &m, span: &span };
            for simd in [Simd::Baseline, Simd::Native] {
                let mut out = vec![9.0; 200];
                look_up_span(simd, &m, &span, &mut out, &check);
                let seen = out.iter().filter(|&&v| v == 0.5).count();
                assert!(
                    seen > 20 && seen < 180,
                    "{seen} of 200 are seen: too one-sided a test"
                );
            }
        }
    }
}
