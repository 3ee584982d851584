//! Lookups of many receivers. Receivers are projected in vector lanes, one batch at a time. A
//! technique then takes the taps of the whole batch, or of one receiver after the other. The
//! arithmetic is that of [`coord`](crate::shadow_map::coord), whose functions are inlined into
//! loops over arrays.

use crate::shadow_map::{
    cascades::{blended, holds, share_of_layer},
    coord::{
        ShadowCoord, clip_w, deepest_depth, is_covered, offset_along_normal, plane_gradient,
        point_over_w, slope_bias, texel_from_point, to_light,
    },
    layers::{MapLayer, ShadowMapUniforms, layer_at},
};
use glam::{Vec2, Vec3};
use umbrage_core::{Arrangement, Simd, SimdTask, Span, math::dot3};

/// Number of receivers that are projected before the taps begin.
pub const BATCH: usize = 64;

/// Comparisons of a technique for one receiver. This is a trait and not a closure, because a method
/// can be marked `#[inline(always)]`. It must be inlined into the loop that is compiled for vector
/// instructions.
pub trait Taps {
    /// Returns the visibility, 0..=1; `offset` is the pixel's index in the span.
    fn visibility(&self, l: &ShadowCoord, offset: usize) -> f32;
}

/// Comparisons of a technique for a batch of receivers. Types with [`Taps`] implement it, too, and
/// process one receiver at a time.
pub trait BatchTaps {
    /// Writes visibilities 0..=1 to all of `out`; `first` is the first pixel's index in the span.
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]);
}

impl<T: Taps> BatchTaps for T {
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            let l = batch.lookup(i);
            *out = if l.covered {
                self.visibility(&l, first + i)
            } else {
                1.0
            };
        }
    }
}

/// Looks up a span of receivers in the map of `m`, and fills `out` with the visibilities that
/// `taps` computes. `out` is as long as the span. Receivers that no layer of the map covers (see
/// [`ShadowCoord::covered`]) are lit.
#[inline]
pub fn look_up_span(
    simd: Simd,
    m: &ShadowMapUniforms,
    span: &Span<'_>,
    out: &mut [f32],
    taps: &impl BatchTaps,
) {
    let mut batch = Batch::new();
    let mut padded = PaddedReceivers::new();
    for first in (0..out.len()).step_by(BATCH) {
        let count = BATCH.min(out.len() - first);
        let out = &mut out[first..first + count];
        let receivers = ReceiverBatch::from(span, first, &mut padded);
        project(simd, m, &receivers, &mut batch);
        simd.run_task(FollowTaps {
            taps,
            batch: &batch,
            first,
            out: &mut *out,
        });
        if m.blends() {
            blend_layers(simd, m, &receivers, taps, &batch, first, out);
        }
    }
}

/// Blends the visibilities in `out` with those of the next layers, near the boundaries of the
/// layers of `batch`. Twin of `receive` in receive_blended.wgsl.
#[inline(never)]
fn blend_layers(
    simd: Simd,
    m: &ShadowMapUniforms,
    receivers: &ReceiverBatch<'_>,
    taps: &impl BatchTaps,
    batch: &Batch,
    first: usize,
    out: &mut [f32],
) {
    let mut shares = [1.0; BATCH];
    // Receivers without a second layer stay uncovered.
    let mut next = Batch::new();
    next.layer = [NO_LAYER; BATCH];
    let mut is_needed = false;
    for (i, share) in shares.iter_mut().enumerate().take(out.len()) {
        let layer = batch.layer[i];
        *share = share_of_layer(m, layer, receivers.position(i));
        if *share < 1.0 {
            next.layer[i] = layer + 1;
            is_needed = true;
        }
    }
    if !is_needed {
        return;
    }
    project_in_layers(simd, m, receivers, &mut next);
    let mut answers = [1.0; BATCH];
    simd.run_task(FollowTaps {
        taps,
        batch: &next,
        first,
        out: &mut answers[..out.len()],
    });
    for (i, out) in out.iter_mut().enumerate() {
        if shares[i] < 1.0 {
            *out = blended(*out, answers[i], shares[i]);
        }
    }
}

struct FollowTaps<'a, T> {
    taps: &'a T,
    batch: &'a Batch,
    first: usize,
    out: &'a mut [f32],
}

impl<T: BatchTaps> SimdTask for FollowTaps<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.taps.visibilities(self.batch, self.first, self.out);
    }
}

/// One value for each receiver of a batch.
pub(crate) type Lanes<T> = [T; BATCH];

/// Map coordinates of up to [`BATCH`] receivers, with an array for each field of [`ShadowCoord`].
#[derive(Clone, Debug)]
pub struct Batch {
    pub(crate) x: Lanes<f32>,
    pub(crate) y: Lanes<f32>,
    pub(crate) depth: Lanes<f32>,
    pub(crate) deepest: Lanes<f32>,
    pub(crate) right: Lanes<f32>,
    pub(crate) down: Lanes<f32>,
    pub(crate) layer: Lanes<i32>,
    pub(crate) covered: Lanes<bool>,
}

impl Batch {
    pub(crate) fn new() -> Self {
        let zero = [0.0; BATCH];
        Self {
            x: zero,
            y: zero,
            depth: zero,
            deepest: zero,
            right: zero,
            down: zero,
            layer: [0; BATCH],
            covered: [false; BATCH],
        }
    }

    /// Returns the map coordinates of receiver `i` of the batch.
    #[inline(always)]
    pub fn lookup(&self, i: usize) -> ShadowCoord {
        ShadowCoord {
            texel: Vec2::new(self.x[i], self.y[i]),
            depth: self.depth[i],
            gradient: Vec2::new(self.right[i], self.down[i]),
            deepest: self.deepest[i],
            layer: self.layer[i],
            covered: self.covered[i],
        }
    }

    /// Fills `out` with the visibilities of the first receivers, and 1 where a receiver isn't
    /// covered.
    #[inline(always)]
    pub(crate) fn one_by_one(&self, out: &mut [f32], answer: impl Fn(&ShadowCoord, usize) -> f32) {
        for (i, out) in out.iter_mut().enumerate() {
            let l = self.lookup(i);
            *out = if l.covered { answer(&l, i) } else { 1.0 };
        }
    }

    /// Reports whether the compared depth of every receiver is constant over the map.
    #[inline(always)]
    pub(crate) fn is_level(&self) -> bool {
        let mut is_level = true;
        // No early return, so that this is one loop over lanes.
        for i in 0..BATCH {
            is_level &= (self.right[i] == 0.0) & (self.down[i] == 0.0);
        }
        is_level
    }

    /// Copies the lookups in one layer from a batch in which every receiver was looked up in that
    /// layer.
    fn take_layer(&mut self, layer: i32, all: &Batch) {
        for i in 0..BATCH {
            if self.layer[i] != layer {
                continue;
            }
            self.x[i] = all.x[i];
            self.y[i] = all.y[i];
            self.depth[i] = all.depth[i];
            self.deepest[i] = all.deepest[i];
            self.right[i] = all.right[i];
            self.down[i] = all.down[i];
            self.covered[i] = all.covered[i];
        }
    }
}

/// Batch of a span's receivers, with an array for each coordinate.
#[derive(Clone, Copy)]
pub(crate) struct ReceiverBatch<'a> {
    x: &'a Lanes<f32>,
    y: &'a Lanes<f32>,
    z: &'a Lanes<f32>,
    nx: &'a Lanes<f32>,
    ny: &'a Lanes<f32>,
    nz: &'a Lanes<f32>,
}

impl<'a> ReceiverBatch<'a> {
    /// Returns up to [`BATCH`] receivers from `first` on. They are copied to `room` if the span
    /// ends before the batch does.
    pub(crate) fn from(span: &'a Span<'a>, first: usize, room: &'a mut PaddedReceivers) -> Self {
        if let Some(receivers) = Self::borrow_full_batch(span, first) {
            return receivers;
        }
        let values = [span.x, span.y, span.z, span.nx, span.ny, span.nz];
        room.0 = values.map(|values| padded_lanes(values, first));
        let [x, y, z, nx, ny, nz] = &room.0;
        Self {
            x,
            y,
            z,
            nx,
            ny,
            nz,
        }
    }

    /// Borrows the [`BATCH`] receivers from `first` on; `None` if the span ends before.
    fn borrow_full_batch(span: &Span<'a>, first: usize) -> Option<Self> {
        Some(Self {
            x: span.x[first..].first_chunk()?,
            y: span.y[first..].first_chunk()?,
            z: span.z[first..].first_chunk()?,
            nx: span.nx[first..].first_chunk()?,
            ny: span.ny[first..].first_chunk()?,
            nz: span.nz[first..].first_chunk()?,
        })
    }

    #[inline(always)]
    pub(crate) fn position(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    pub(crate) fn normal(&self, i: usize) -> Vec3 {
        Vec3::new(self.nx[i], self.ny[i], self.nz[i])
    }
}

/// Storage for the receivers of a partial batch.
pub(crate) struct PaddedReceivers([Lanes<f32>; 6]);

impl PaddedReceivers {
    pub(crate) fn new() -> Self {
        Self([[0.0; BATCH]; 6])
    }
}

/// Copies the values from `first` to the span's end, and 0 after them.
fn padded_lanes(values: &[f32], first: usize) -> Lanes<f32> {
    let mut lanes = [0.0; BATCH];
    let rest = &values[first..];
    lanes[..rest.len()].copy_from_slice(rest);
    lanes
}

/// Value of [`Batch::layer`] for receivers that are not looked up.
const NO_LAYER: i32 = -1;

/// Looks up a batch of receivers, each in its layer. Projecting receivers one after the other makes
/// whole lookups take 1.2 to 3.2 times as long (hard to 9x9, 1280x720, `street`, a map of 2048,
/// AVX2).
fn project(simd: Simd, m: &ShadowMapUniforms, receivers: &ReceiverBatch<'_>, batch: &mut Batch) {
    match m.arrangement() {
        Arrangement::Single => {
            project_into(simd, m, &m.layers[0], receivers, batch);
            return;
        }
        Arrangement::Cascades(_) => simd.run_task(PickCascades {
            m,
            receivers,
            layers: &mut batch.layer,
        }),
        Arrangement::Cube => {
            for i in 0..BATCH {
                batch.layer[i] = layer_at(m, receivers.position(i));
            }
        }
    }
    project_in_layers(simd, m, receivers, batch);
}

/// Looks up those receivers of a batch that have a layer, each in its own.
fn project_in_layers(
    simd: Simd,
    m: &ShadowMapUniforms,
    receivers: &ReceiverBatch<'_>,
    batch: &mut Batch,
) {
    let mut present = 0_u32;
    for layer in batch.layer {
        if layer != NO_LAYER {
            present |= 1 << layer;
        }
    }
    // Neighbours are mostly in one layer. If a batch spans several layers, look up all its
    // receivers in each of them.
    let mut all = Batch::new();
    for (layer, uniforms) in (0..).zip(m.used_layers()) {
        if present & (1 << layer) != 0 {
            project_into(simd, m, uniforms, receivers, &mut all);
            batch.take_layer(layer, &all);
        }
    }
}

/// Vectorised [`layer_at`]: finds the cascade of each receiver of a batch.
struct PickCascades<'a> {
    m: &'a ShadowMapUniforms,
    receivers: &'a ReceiverBatch<'a>,
    layers: &'a mut Lanes<i32>,
}

impl SimdTask for PickCascades<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let m = self.m;
        let receivers = *self.receivers;
        let last = m.used_layers().len() - 1;
        let mut picked = [last as i32; BATCH];
        // Go from the last to the first, so that the first cascade that holds a receiver wins.
        for index in (0..last).rev() {
            let layer = m.layers[index];
            for (i, picked) in picked.iter_mut().enumerate() {
                let is_held = holds(m, &layer, receivers.position(i));
                *picked = if is_held { index as i32 } else { *picked };
            }
        }
        *self.layers = picked;
    }
}

/// Looks up receivers in one layer, with the loop specialised for the light and the bias.
fn project_into(
    simd: Simd,
    m: &ShadowMapUniforms,
    layer: &MapLayer,
    receivers: &ReceiverBatch<'_>,
    out: &mut Batch,
) {
    // A light without a position has the same direction for all receivers.
    let has_position = m.light.w != 0.0;
    match (has_position, layer.moves_receivers()) {
        (false, false) => simd.run_task(Project::<false, false>::new(m, layer, receivers, out)),
        (false, true) => simd.run_task(Project::<false, true>::new(m, layer, receivers, out)),
        (true, false) => simd.run_task(Project::<true, false>::new(m, layer, receivers, out)),
        (true, true) => simd.run_task(Project::<true, true>::new(m, layer, receivers, out)),
    }
}

/// Lookup of receivers in one layer. `LOCAL`: the light has a position. `OFFSET`: receivers move
/// along their normals.
struct Project<'a, const LOCAL: bool, const OFFSET: bool> {
    m: &'a ShadowMapUniforms,
    layer: &'a MapLayer,
    receivers: &'a ReceiverBatch<'a>,
    out: &'a mut Batch,
}

impl<'a, const LOCAL: bool, const OFFSET: bool> Project<'a, LOCAL, OFFSET> {
    fn new(
        m: &'a ShadowMapUniforms,
        layer: &'a MapLayer,
        receivers: &'a ReceiverBatch<'a>,
        out: &'a mut Batch,
    ) -> Self {
        Self {
            m,
            layer,
            receivers,
            out,
        }
    }
}

impl<const LOCAL: bool, const OFFSET: bool> SimdTask for Project<'_, LOCAL, OFFSET> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // Copy all inputs and write to separate arrays. Through references, the compiler cannot
        // exclude that a store changes the next lane's input, and does not vectorise.
        let layer = *self.layer;
        let light = self.m.light;
        let size = self.m.size;
        let receivers = *self.receivers;
        let direction = light.truncate();
        let zero = [0.0; BATCH];
        let mut points = [zero; 3];
        let mut x = zero;
        let mut y = zero;
        let mut depths = zero;
        let mut deepest = zero;
        let mut covered = [false; BATCH];
        // Bias and project the receivers.
        for i in 0..BATCH {
            let p = receivers.position(i);
            let n = receivers.normal(i);
            let to_light = if LOCAL { to_light(light, p) } else { direction };
            let n_dot_l = dot3(n, to_light);
            let bias = layer.constant + slope_bias(layer.slope, layer.slope_min, n_dot_l);
            let p = if OFFSET {
                offset_along_normal(&layer, p, n, n_dot_l)
            } else {
                p
            };
            let w = clip_w(&layer.clip_from_world, p);
            let point = point_over_w(&layer.clip_from_world, p, w);
            let texel = texel_from_point(point, size);
            let depth = point.z - bias;
            x[i] = texel.x;
            y[i] = texel.y;
            depths[i] = depth;
            deepest[i] = deepest_depth(&layer, depth);
            covered[i] = is_covered(&layer, point.z, w);
            points[0][i] = point.x;
            points[1][i] = point.y;
            points[2][i] = point.z;
        }
        // Store the results.
        let out = self.out;
        out.x = x;
        out.y = y;
        out.depth = depths;
        out.deepest = deepest;
        out.covered = covered;
        if layer.follows_plane() {
            follow_planes(size, &layer, &points, &receivers, out);
        } else {
            out.right = zero;
            out.down = zero;
        }
    }
}

/// Computes the gradients of the receivers' planes. This is a separate loop, because the compiler
/// does not vectorise it together with the rest of the arithmetic.
#[inline(always)]
fn follow_planes(
    size: f32,
    layer: &MapLayer,
    points: &[Lanes<f32>; 3],
    receivers: &ReceiverBatch<'_>,
    out: &mut Batch,
) {
    let mut right = [0.0; BATCH];
    let mut down = [0.0; BATCH];
    for i in 0..BATCH {
        let point = Vec3::new(points[0][i], points[1][i], points[2][i]);
        let n = receivers.normal(i);
        let limit = layer.receiver_plane;
        let gradient = plane_gradient(layer.clip_from_world, point, n, size, limit);
        right[i] = gradient.x;
        down[i] = gradient.y;
    }
    out.right = right;
    out.down = down;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadow_map::{coord::shadow_coord, layers::MAX_LAYERS};
    use glam::{Mat4, Quat, Vec4, dcamera::rh::proj::directx};

    /// Slope, normal offset and receiver plane of a bias.
    struct BiasCase {
        slope: f32,
        normal_offset: f32,
        receiver_plane: f32,
    }

    fn map(light: Vec4, layer_count: u32, bias: &BiasCase) -> ShadowMapUniforms {
        let clip_from_view = directx::perspective(1.2, 1.0, 0.3, 40.0).as_mat4();
        let layer = |i: usize| {
            // Layers have different orientations and differ in all their fields.
            let turn = Mat4::from_quat(Quat::from_rotation_y(i as f32));
            let share = 1.0 + i as f32;
            let [far, deepest] = if i.is_multiple_of(2) {
                [f32::MAX, 1.0]
            } else {
                [1.0, f32::MAX]
            };
            MapLayer {
                clip_from_world: clip_from_view * turn,
                texel: 0.01 * share,
                far,
                constant: 1e-3 * share,
                slope: bias.slope * share,
                slope_min: bias.slope * 0.1,
                normal_offset: bias.normal_offset * share,
                receiver_plane: bias.receiver_plane * share,
                deepest_tap: 1.0,
                depth_in_texels: 300.0,
                deepest,
            }
        };
        ShadowMapUniforms {
            layer_count,
            packed: 0,
            clamped: 0,
            pick_reach: 40.0,
            blend: 0.0,
            layers: std::array::from_fn(layer),
            light,
            size: 300.0,
            sample_gain: 1.0,
        }
    }

    struct Check<'a> {
        m: &'a ShadowMapUniforms,
        span: &'a Span<'a>,
    }

    fn bits(l: &ShadowCoord) -> [u32; 6] {
        [
            l.texel.x,
            l.texel.y,
            l.depth,
            l.gradient.x,
            l.gradient.y,
            l.deepest,
        ]
        .map(f32::to_bits)
    }

    impl Taps for Check<'_> {
        fn visibility(&self, l: &ShadowCoord, i: usize) -> f32 {
            let plain = shadow_coord(self.m, self.span.position(i), self.span.normal(i));
            assert_eq!(bits(l), bits(&plain), "{i}");
            assert_eq!((l.layer, l.covered), (plain.layer, plain.covered), "{i}");
            0.5
        }
    }

    fn wave(frequency: f32, scale: f32) -> Vec<f32> {
        let value = |i: i32| (i as f32 * frequency).sin() * scale;
        (0..200).map(value).collect()
    }

    /// Compares the lanes with the scalar function, for points before, behind and next to the
    /// light.
    #[test]
    fn lanes_equal_the_plain_function() {
        let x = wave(0.7, 20.0);
        let y = wave(1.3, 20.0);
        let z = wave(2.3, 50.0);
        let nx = wave(0.31, 0.5);
        let ny = wave(0.57, 0.5);
        let nz = wave(0.9, 0.5);
        let triangle = vec![0; 200];
        let span = Span {
            first: glam::UVec2::ZERO,
            x: &x,
            y: &y,
            z: &z,
            nx: &nx,
            ny: &ny,
            nz: &nz,
            triangle: &triangle,
        };
        let sun = Vec4::new(0.0, 1.0, 0.0, 0.0);
        let lamp = Vec4::new(1.0, 4.0, 2.0, 1.0);
        let many = MAX_LAYERS as u32;
        for (light, layers) in [(sun, 1), (lamp, 1), (lamp, 6), (sun, many), (sun, 3)] {
            for [slope, normal_offset, receiver_plane] in [
                [0.05, 0.0, 0.0],
                [0.0, 0.0, 0.0],
                [0.0, 0.0, 0.1],
                [0.05, 0.0, 1e-4],
                [0.0, 1.5, 0.0],
                [0.05, 1.5, 0.1],
            ] {
                let bias = BiasCase {
                    slope,
                    normal_offset,
                    receiver_plane,
                };
                let m = map(light, layers, &bias);
                let check = Check { m: &m, span: &span };
                for simd in [Simd::Baseline, Simd::Native] {
                    let mut out = vec![9.0; 200];
                    look_up_span(simd, &m, &span, &mut out, &check);
                    let covered = out.iter().filter(|&&v| v == 0.5).count();
                    assert!((20..180).contains(&covered), "{covered} of 200 are covered");
                }
            }
        }
    }
}
