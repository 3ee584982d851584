//! Lookup in a map of moments. The blend of four texels is written out, because the rounding of
//! samplers varies and those of core WebGPU don't filter 32-bit floats.

use crate::{
    filtering::moments::{
        bounds::{BOUNDS, without_bleeding},
        exp2::EXP2,
        map::{BleedingReduction, MomentImages},
        mipmaps::{
            MIPMAPS, MipmapUniforms, added_variance, level_reach, level_side, level_start,
            mipmap_level, texels_spanned,
        },
        of_depth::{MOMENTS_OF_DEPTH, centre_depth},
        stored::Encoding,
    },
    lanes::{
        batch::{BATCH, Batch, BatchTaps, Lanes, Taps, look_up_span},
        whole::{floor, whole_to_u32},
    },
    shadow_map::{
        coord::{ShadowCoord, clip_w, to_light},
        layers::{ShadowMapUniforms, layer_at},
    },
};
use glam::{Vec2, Vec3};
use umbrage_core::{
    Inputs, Module, Span,
    math::{dot3, greater, lesser},
    module,
};

/// The WGSL half of the lookup. It reads the kernel's first image.
const LOOK_UP: Module = module!("look_up");
/// WGSL for maps without mipmaps.
const ONE_LEVEL: Module = module!("look_up_one_level");
/// WGSL for maps with mipmaps. It reads the kernel's second image, too.
const MIPMAPPED: Module = module!("look_up_mipmapped");

/// Returns the WGSL of a kernel that looks up moments: the map's modules, those of moments, and
/// `own`.
///
/// `own` declares the uniforms and two functions:
/// `fn lit_by_moments(moments: vec4f, depth: f32) -> f32` returns the fraction of light at a
/// centred depth. `fn compared_depth(l: ShadowCoord, spread: f32) -> f32` returns the clip depth to
/// compare. A coarser level increases the variance of the averaged positions by `spread` texels
/// squared. The map's uniforms must be the kernel's field `lookup`, those of its levels `mipmaps`.
pub(crate) fn modules(map: MomentMap<'_>, own: &[Module]) -> Vec<Module> {
    let mut modules = map.lookup.modules(&[EXP2, MOMENTS_OF_DEPTH, BOUNDS]);
    modules.extend(map.images.encoding().modules());
    let has_mipmaps = map.mipmaps.levels > 0;
    let levels = if has_mipmaps { MIPMAPPED } else { ONE_LEVEL };
    modules.extend([MIPMAPS, LOOK_UP, levels]);
    modules.extend(own);
    modules
}

/// Bound of light at a depth from `CHANNELS` moments. This is a trait and not a closure for the
/// same reason as [`Taps`].
pub(crate) trait LightBound<const CHANNELS: usize> {
    /// Returns the fraction of light, 0..=1, at a centred depth. `lit_by_moments` in WGSL.
    fn lit_fraction(&self, moments: [f32; CHANNELS], depth: f32) -> f32;

    /// Returns the clip depth to compare. `compared_depth` in WGSL.
    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord, _spread: f32) -> f32 {
        l.depth
    }
}

/// Map of moments that a kernel reads.
#[derive(Clone, Copy)]
pub(crate) struct MomentMap<'a> {
    /// Kind of the stored moments.
    pub(crate) images: MomentImages,
    /// Layers of the map.
    pub(crate) lookup: &'a ShadowMapUniforms,
    /// Levels, and the data for selecting them.
    pub(crate) mipmaps: &'a MipmapUniforms,
    /// Light-bleeding reduction of the lookup.
    pub(crate) bleeding: BleedingReduction,
}

/// Implements the methods that all kernels with moments share.
macro_rules! moment_kernel {
    ($kernel:ty) => {
        impl $kernel {
            fn moment_map(&self) -> $crate::filtering::moments::look_up::MomentMap<'_> {
                $crate::filtering::moments::look_up::MomentMap {
                    images: self.images,
                    lookup: &self.uniforms.lookup,
                    mipmaps: &self.uniforms.mipmaps,
                    bleeding: $crate::filtering::moments::map::BleedingReduction {
                        amount: self.uniforms.bleeding,
                        scale: self.uniforms.bleeding_scale,
                    },
                }
            }

            /// Returns the reach, in texels beyond its own, of the lookup of a receiver at
            /// `position` (world space) with the unit `normal`; `None` if it is the same for all.
            pub fn lookup_reach(&self, position: glam::Vec3, normal: glam::Vec3) -> Option<f32> {
                self.moment_map().reach(position, normal)
            }
        }
    };
}
pub(crate) use moment_kernel;

impl MomentMap<'_> {
    /// Returns the level of a receiver (x, the finer of two) and the weight of the coarser one (y).
    #[inline(always)]
    fn level(&self, layer: i32, position: Vec3, normal: Vec3) -> Vec2 {
        let MipmapUniforms { levels, eye, axis } = *self.mipmaps;
        let map = &self.lookup.layers[layer as usize];
        let texel = map.texel * clip_w(&map.clip_from_world, position);
        let n_dot_l = dot3(normal, to_light(self.lookup.light, position));
        let spanned = texels_spanned(eye, axis, position, normal, n_dot_l, texel);
        mipmap_level(spanned, levels)
    }

    /// Returns the reach of a receiver's lookup, texels; `None` if it is the same for all.
    pub(crate) fn reach(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        if self.mipmaps.levels == 0 {
            return None;
        }
        let layer = layer_at(self.lookup, position);
        let level = self.level(layer, position, normal);
        let coarsest = level.x as u32 + u32::from(level.y > 0.0);
        Some(self.images.blur as f32 + level_reach(coarsest))
    }
}

/// Looks up a span of receivers in the map of moments. It is the kernel's first image; the second
/// image holds the levels from 1 on, if there are any.
pub(crate) fn look_up<const CHANNELS: usize>(
    inputs: &Inputs<'_>,
    map: MomentMap<'_>,
    span: &Span<'_>,
    out: &mut [f32],
    bound: &impl LightBound<CHANNELS>,
) {
    let lookup = map.lookup;
    let lookups = MomentLookups {
        finest: texels_of(inputs, 0),
        encoding: map.images.encoding(),
        size: lookup.size as i32,
        clamped: lookup.clamped != 0,
        bound,
        bleeding: map.bleeding,
    };
    if map.mipmaps.levels == 0 {
        look_up_span(inputs.simd, lookup, span, out, &lookups);
        return;
    }
    let lookups = MipmappedLookups {
        finest: lookups,
        coarser: texels_of(inputs, 1),
        map,
        span,
    };
    look_up_span(inputs.simd, lookup, span, out, &lookups);
}

/// Returns an image of moments.
fn texels_of<'a, const CHANNELS: usize>(inputs: &Inputs<'a>, image: usize) -> Texels<'a, CHANNELS> {
    let image = &inputs.images[image];
    Texels {
        texels: image.texels.as_chunks().0,
        width: image.desc.size.x as usize,
        height: image.desc.size.y as usize,
    }
}

/// Image of moments: all layers, row by row.
#[derive(Clone, Copy)]
struct Texels<'a, const CHANNELS: usize> {
    texels: &'a [[f32; CHANNELS]],
    width: usize,
    height: usize,
}

/// Lookups in a map of moments.
struct MomentLookups<'a, const CHANNELS: usize, B> {
    finest: Texels<'a, CHANNELS>,
    encoding: Encoding,
    /// Side of each layer, texels.
    size: i32,
    /// True if the map's edge repeats; otherwise receivers outside it are lit.
    clamped: bool,
    bound: &'a B,
    bleeding: BleedingReduction,
}

impl<const CHANNELS: usize, B: LightBound<CHANNELS>> BatchTaps for MomentLookups<'_, CHANNELS, B> {
    /// Runs in vector lanes, 1.9 to 2.9 times as fast as one receiver after the other (1280x720,
    /// `street`, a map of 2048, AVX2). There are three passes. The first finds texel indices; the
    /// second only loads, so that many loads are in flight; the third computes the bounds.
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, _: usize, out: &mut [f32]) {
        let places = Places::new(self.finest, self.size, batch);
        let mut texels = [[[0.0; BATCH]; CHANNELS]; 4];
        for (numbers, texels) in places.texels.iter().zip(&mut texels) {
            for (i, &number) in numbers.iter().enumerate() {
                let texel = self.finest.texels.get(number as usize);
                debug_assert!(texel.is_some(), "texel {number} is outside the map");
                // Avoid a panic, so that loads need not keep their order.
                let Some(texel) = texel else {
                    continue;
                };
                for channel in 0..CHANNELS {
                    texels[channel][i] = texel[channel];
                }
            }
        }
        // Use two loops, so that the one for most maps has no branch.
        let lit = if self.encoding == Encoding::Floats {
            self.lit_at_all::<true>(batch, &places, &texels)
        } else {
            self.lit_at_all::<false>(batch, &places, &texels)
        };
        batch.one_by_one(out, |l, i| self.known_visibility(l).unwrap_or(lit[i]));
    }
}

/// Four texels around each receiver of a batch.
struct Places {
    /// Indices among all texels: top left, top right, bottom left, bottom right. 0 if a receiver is
    /// not covered.
    texels: [Lanes<u32>; 4],
    /// Weight of the right texels.
    right: Lanes<f32>,
    /// Weight of the lower texels.
    down: Lanes<f32>,
}

impl Places {
    /// Returns the texels in an image with layers of this side.
    #[inline(always)]
    fn new<const CHANNELS: usize>(image: Texels<'_, CHANNELS>, side: i32, batch: &Batch) -> Self {
        let [width, height] = [image.width as u32, image.height as u32];
        let last = (side - 1) as f32;
        let mut out = Self {
            texels: [[0; BATCH]; 4],
            right: [0.0; BATCH],
            down: [0.0; BATCH],
        };
        for i in 0..BATCH {
            let is_covered = batch.covered[i];
            let place_x = batch.x[i] - 0.5;
            let place_y = batch.y[i] - 0.5;
            let corner_x = floor(place_x);
            let corner_y = floor(place_y);
            out.right[i] = place_x - corner_x;
            out.down[i] = place_y - corner_y;
            let left = on_map(corner_x, last);
            let right = on_map(corner_x + 1.0, last);
            let first_row = (batch.layer[i] as u32).wrapping_mul(height);
            let upper = first_row
                .wrapping_add(on_map(corner_y, last))
                .wrapping_mul(width);
            let lower = first_row
                .wrapping_add(on_map(corner_y + 1.0, last))
                .wrapping_mul(width);
            let numbers = [
                upper.wrapping_add(left),
                upper.wrapping_add(right),
                lower.wrapping_add(left),
                lower.wrapping_add(right),
            ];
            for (texels, number) in out.texels.iter_mut().zip(numbers) {
                texels[i] = if is_covered { number } else { 0 };
            }
        }
        out
    }
}

/// Clamps an integer value to 0..=`last` and converts it.
#[inline(always)]
fn on_map(whole: f32, last: f32) -> u32 {
    whole_to_u32(greater(lesser(whole, last), 0.0))
}

/// Returns the blended moments of four texels: top left, top right, bottom left, bottom right.
#[inline(always)]
fn blend<const CHANNELS: usize>(texels: &[[f32; CHANNELS]; 4], share: Vec2) -> [f32; CHANNELS] {
    let [top_left, top_right, bottom_left, bottom_right] = texels;
    let mut moments = [0.0; CHANNELS];
    for (i, moment) in moments.iter_mut().enumerate() {
        let top = top_left[i] + (top_right[i] - top_left[i]) * share.x;
        let bottom = bottom_left[i] + (bottom_right[i] - bottom_left[i]) * share.x;
        *moment = top + (bottom - top) * share.y;
    }
    moments
}

impl<const CHANNELS: usize, B: LightBound<CHANNELS>> MomentLookups<'_, CHANNELS, B> {
    /// Returns the fractions of light from the moments between the texels of each receiver of a
    /// batch. `FLOATS` means that the texels hold moments without an encoding.
    #[inline(always)]
    fn lit_at_all<const FLOATS: bool>(
        &self,
        batch: &Batch,
        places: &Places,
        texels: &[[Lanes<f32>; CHANNELS]; 4],
    ) -> Lanes<f32> {
        let mut out = [0.0; BATCH];
        for i in 0..BATCH {
            let mut corners = [[0.0; CHANNELS]; 4];
            for (corner, texels) in corners.iter_mut().zip(texels) {
                for channel in 0..CHANNELS {
                    corner[channel] = texels[channel][i];
                }
                if !FLOATS {
                    self.encoding.load(corner);
                }
            }
            let moments = blend(&corners, Vec2::new(places.right[i], places.down[i]));
            out[i] = self.lit_at(&batch.lookup(i), moments, 0.0);
        }
        out
    }

    /// Returns the visibility of receivers outside the map or beyond the far plane, which need no
    /// moments.
    #[inline(always)]
    fn known_visibility(&self, l: &ShadowCoord) -> Option<f32> {
        let size = self.size as f32;
        let is_inside =
            l.texel.x >= 0.0 && l.texel.y >= 0.0 && l.texel.x < size && l.texel.y < size;
        if !is_inside && !self.clamped {
            return Some(1.0);
        }
        // Nothing is stored beyond the far plane.
        (l.own_depth() > 1.0).then_some(0.0)
    }

    /// Returns the fraction of light from moments at a receiver. A coarser level increases the
    /// variance of the averaged positions by `spread` texels squared.
    #[inline(always)]
    fn lit_at(&self, l: &ShadowCoord, moments: [f32; CHANNELS], spread: f32) -> f32 {
        let depth = self.bound.compared_depth(l, spread).min(l.deepest);
        let depth = centre_depth(depth);
        let lit = self.bound.lit_fraction(moments, depth);
        without_bleeding(lit, self.bleeding.amount, self.bleeding.scale)
    }

    /// Returns the moments at a receiver, blended between four texels.
    #[inline(always)]
    fn blended_moments(&self, l: &ShadowCoord) -> [f32; CHANNELS] {
        self.between_texels(self.finest, l.texel, self.size, 0, l.layer)
    }

    /// Returns the moments at a position, texels, in a level of this side that starts at row
    /// `start` of an image.
    #[inline(always)]
    fn between_texels(
        &self,
        image: Texels<'_, CHANNELS>,
        at: Vec2,
        side: i32,
        start: i32,
        layer: i32,
    ) -> [f32; CHANNELS] {
        let place = at - 0.5;
        let corner = place.floor();
        let share = place - corner;
        let last = side - 1;
        let left = (corner.x as i32).clamp(0, last);
        let right = (corner.x as i32 + 1).clamp(0, last);
        let upper = (corner.y as i32).clamp(0, last) + start;
        let lower = (corner.y as i32 + 1).clamp(0, last) + start;
        let texel = |x: i32, y: i32| {
            let row = layer as usize * image.height + y as usize;
            let mut moments = image.texels[row * image.width + x as usize];
            self.encoding.load(&mut moments);
            moments
        };
        let texels = [
            texel(left, upper),
            texel(right, upper),
            texel(left, lower),
            texel(right, lower),
        ];
        blend(&texels, share)
    }
}

/// Lookups in a map of moments with mipmaps.
struct MipmappedLookups<'a, const CHANNELS: usize, B> {
    finest: MomentLookups<'a, CHANNELS, B>,
    /// Levels from 1 on, one below the other.
    coarser: Texels<'a, CHANNELS>,
    map: MomentMap<'a>,
    span: &'a Span<'a>,
}

impl<const CHANNELS: usize, B: LightBound<CHANNELS>> Taps for MipmappedLookups<'_, CHANNELS, B> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, offset: usize) -> f32 {
        if let Some(known) = self.finest.known_visibility(l) {
            return known;
        }
        let span = self.span;
        let position = Vec3::new(span.x[offset], span.y[offset], span.z[offset]);
        let normal = Vec3::new(span.nx[offset], span.ny[offset], span.nz[offset]);
        let level = self.map.level(l.layer, position, normal);
        let finer = level.x as u32;
        let mut moments = self.blended_level(l, finer);
        if level.y > 0.0 {
            let coarser = self.blended_level(l, finer + 1);
            for (moment, coarser) in moments.iter_mut().zip(coarser) {
                *moment += (coarser - *moment) * level.y;
            }
        }
        self.finest.lit_at(l, moments, added_variance(level))
    }
}

impl<const CHANNELS: usize, B: LightBound<CHANNELS>> MipmappedLookups<'_, CHANNELS, B> {
    /// Returns the moments at a receiver in a level.
    #[inline(always)]
    fn blended_level(&self, l: &ShadowCoord, level: u32) -> [f32; CHANNELS] {
        if level == 0 {
            return self.finest.blended_moments(l);
        }
        let size = self.finest.size as u32;
        let at = l.texel * (1.0 / (1_u32 << level) as f32);
        let side = level_side(size, level) as i32;
        let start = level_start(size, level) as i32;
        self.finest
            .between_texels(self.coarser, at, side, start, l.layer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::fixtures::{LAYERS, SIZE, batch};

    /// Test bound whose result differs for all moments and depths.
    struct DepthReporter;

    impl<const CHANNELS: usize> LightBound<CHANNELS> for DepthReporter {
        fn lit_fraction(&self, moments: [f32; CHANNELS], depth: f32) -> f32 {
            let mut reported = 0.1 * depth.abs();
            for (i, moment) in moments.into_iter().enumerate() {
                reported += moment / (i + 2) as f32;
            }
            reported
        }
    }

    /// Returns numbers 0..1 in pseudo-random order, valid in all encodings.
    fn texels<const CHANNELS: usize>() -> Vec<[f32; CHANNELS]> {
        let value = |i: i32| (i.wrapping_mul(7919) % 1009) as f32 / 1009.0;
        let texel = |i: i32| std::array::from_fn(|k| value(i * CHANNELS as i32 + k as i32));
        (0..SIZE * SIZE * LAYERS).map(texel).collect()
    }

    fn lookups<const CHANNELS: usize>(
        texels: &[[f32; CHANNELS]],
        encoding: Encoding,
        clamped: bool,
    ) -> MomentLookups<'_, CHANNELS, DepthReporter> {
        MomentLookups {
            finest: Texels {
                texels,
                width: SIZE as usize,
                height: SIZE as usize,
            },
            encoding,
            size: SIZE,
            clamped,
            bound: &DepthReporter,
            bleeding: BleedingReduction {
                amount: 0.0,
                scale: 0.4,
            },
        }
    }

    /// Returns how many results of batches differ from those of single receivers in `judged`. The
    /// second number counts the comparisons.
    fn count_differing<const CHANNELS: usize>(
        judged: &[[f32; CHANNELS]],
        encoding: Encoding,
        clamped: bool,
    ) -> [usize; 2] {
        let texels = texels::<CHANNELS>();
        let found = lookups(&texels, encoding, clamped);
        let expected = lookups(judged, encoding, clamped);
        let mut out = [0; 2];
        for turn in 0..40 {
            let batch = batch(turn, turn % 2 == 0);
            let count = if turn % 7 == 0 { 13 } else { BATCH };
            let mut lit = [9.0; BATCH];
            found.visibilities(&batch, 0, &mut lit[..count]);
            for (i, &lit) in lit[..count].iter().enumerate() {
                let l = batch.lookup(i);
                let single = if !l.covered {
                    1.0
                } else if let Some(known) = expected.known_visibility(&l) {
                    known
                } else {
                    expected.lit_at(&l, expected.blended_moments(&l), 0.0)
                };
                out[0] += usize::from(lit != single);
                out[1] += 1;
            }
        }
        out
    }

    fn check<const CHANNELS: usize>(encodings: &[Encoding]) {
        for clamped in [false, true] {
            for &encoding in encodings {
                let [other, all] = count_differing(&texels::<CHANNELS>(), encoding, clamped);
                assert!(other == 0 && all > 2000, "{encoding:?}: {other} of {all}");
                // Negative control: one channel is slightly greater.
                let mut spoilt = texels::<CHANNELS>();
                spoilt
                    .iter_mut()
                    .for_each(|texel| texel[CHANNELS - 1] += 0.01);
                let [other, _] = count_differing(&spoilt, encoding, clamped);
                assert!(other > all / 4, "{encoding:?}: {other} of {all}");
            }
        }
    }

    #[test]
    fn batches_are_as_single_receivers() {
        check::<2>(&[Encoding::Floats, Encoding::Variance16]);
        check::<4>(&[Encoding::Floats, Encoding::Powers16]);
    }
}
