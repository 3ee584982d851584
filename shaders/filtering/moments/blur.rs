//! A moment map: moments of depths, each texel the mean over a square of them.

use crate::{
    filtering::moments::{
        exp2::EXP2,
        of_depth::{MOMENTS_OF_DEPTH, MomentKind, MomentsOfRow},
        stored::{Encoding, MomentPrecision, Store},
        tile::MomentTile,
    },
    shadow_map::{
        packing::unpack_depth,
        variants::{constant, stored_depth},
    },
};
use glam::{IVec2, UVec2, Vec4};
use std::borrow::Cow;
use umbrage_core::{
    FilterKernel, Inputs, Kernel, Module, SimdTask, UniformBlock, module, uniforms,
};

uniforms! {
    /// Uniforms of [`MomentMapKernel`].
    pub struct MomentMapUniforms {
        /// Powers of two per unit of centred depth, of the exponential that rises with depth.
        pub rising: f32,
        /// Powers of two per unit of centred depth, of the exponential that falls with depth.
        pub falling: f32,
        /// Number of texels on each side that are averaged.
        pub radius: i32,
        /// Weight of each texel of a row or a column: one over their number.
        pub share: f32,
        /// Size of the tile that a workgroup writes, texels.
        pub tile: IVec2,
        /// Number of rows of depths that a workgroup reads at a time.
        pub rows: i32,
    }
}

/// Filter from a depth map to a moment map of the same size. Each texel is the mean of the moments
/// of the depths up to `radius` texels away in both directions. The map's edge repeats.
///
/// Means along rows are averaged along columns. Sums run from left to right, and from top to
/// bottom. Only the result is rounded to the map's precision.
#[derive(Clone, Copy, Debug)]
pub struct MomentMapKernel {
    kind: MomentKind,
    encoding: Encoding,
    /// True if each depth of the input occupies four channels.
    packed: bool,
    /// Uniforms.
    pub uniforms: MomentMapUniforms,
}

impl MomentMapKernel {
    /// Returns the filter for these moments and this precision, with a blur of `radius` texels.
    /// `packed` is whether each depth occupies four channels.
    pub(crate) fn new(
        kind: MomentKind,
        precision: MomentPrecision,
        radius: u32,
        packed: bool,
    ) -> Self {
        let (rising, falling) = match kind {
            MomentKind::Variance | MomentKind::Powers => (0.0, 0.0),
            MomentKind::OneExponential { rising } => (rising, 0.0),
            MomentKind::TwoExponentials { rising, falling } => (rising, falling),
        };
        let MomentTile { size, rows } = MomentTile::for_radius(radius);
        Self {
            kind,
            encoding: kind.encoding(precision),
            packed,
            uniforms: MomentMapUniforms {
                rising,
                falling,
                radius: radius as i32,
                share: 1.0 / (2 * radius + 1) as f32,
                tile: size.as_ivec2(),
                rows: rows as i32,
            },
        }
    }

    /// Returns a row of depths of the input.
    fn depths<'a>(&self, inputs: &Inputs<'a>, y: u32, layer: u32) -> Cow<'a, [f32]> {
        let image = &inputs.images[0];
        let first = image.index(0, y as i32, layer);
        let count = image.desc.size.x as usize * image.desc.format.channels();
        let row = &image.texels[first..first + count];
        if !self.packed {
            return Cow::Borrowed(row);
        }
        let depth = |&channels: &[f32; 4]| unpack_depth(Vec4::from_array(channels));
        Cow::Owned(row.as_chunks().0.iter().map(depth).collect())
    }

    /// Writes the means along a row. `padded` has room for the row's moments and `radius` texels
    /// on either side.
    fn average_row(
        &self,
        inputs: &Inputs<'_>,
        depths: &[f32],
        padded: &mut [f32],
        means: &mut [f32],
    ) {
        let channels = means.len() / depths.len();
        let margin = self.uniforms.radius as usize * channels;
        let end = margin + means.len();
        // Compute the moments.
        inputs.simd.run_task(MomentsOfRow {
            kind: self.kind,
            depths,
            out: &mut padded[margin..end],
        });
        // Repeat the first and the last one.
        for i in 0..margin {
            padded[i] = padded[margin + i % channels];
            padded[end + i] = padded[end - channels + i % channels];
        }
        // Average.
        means.fill(0.0);
        for first in (0..=2 * margin).step_by(channels) {
            inputs.simd.run_task(Add {
                sum: &mut *means,
                values: &padded[first..],
            });
        }
        inputs.simd.run_task(Scale {
            values: means,
            factor: self.uniforms.share,
        });
    }
}

const VARIANCE: Module = constant!("MOMENTS = VARIANCE");
const EXPONENTIALS: Module = constant!("MOMENTS = EXPONENTIALS");
const POWERS: Module = constant!("MOMENTS = POWERS");

impl Kernel for MomentMapKernel {
    fn modules(&self) -> Vec<Module> {
        let moments = match self.kind {
            MomentKind::Variance => VARIANCE,
            MomentKind::OneExponential { .. } | MomentKind::TwoExponentials { .. } => EXPONENTIALS,
            MomentKind::Powers => POWERS,
        };
        let mut modules = stored_depth(self.packed).to_vec();
        modules.extend([EXP2, MOMENTS_OF_DEPTH]);
        modules.extend(self.encoding.modules());
        modules.extend([moments, module!("blur")]);
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl FilterKernel for MomentMapKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        self.filter_rows(inputs, start.y, layer, out.len(), out);
    }

    fn filter_rows(
        &self,
        inputs: &Inputs<'_>,
        first: u32,
        layer: u32,
        row_len: usize,
        out: &mut [f32],
    ) {
        let size = inputs.images[0].desc.size;
        let radius = self.uniforms.radius as u32;
        let margin = radius as usize * row_len / size.x as usize;
        let mut padded = vec![0.0; row_len + 2 * margin];
        // Keep the means along the rows that an output row needs, each at its number modulo their
        // count.
        let count = 2 * radius as usize + 1;
        let mut kept = vec![0.0; count * row_len];
        let place = |y: u32| {
            let start = y as usize % count * row_len;
            start..start + row_len
        };
        let mut next = first.saturating_sub(radius);
        for (y, out) in (first..).zip(out.chunks_exact_mut(row_len)) {
            while next <= (y + radius).min(size.y - 1) {
                let depths = self.depths(inputs, next, layer);
                self.average_row(inputs, &depths, &mut padded, &mut kept[place(next)]);
                next += 1;
            }
            // Average along columns. The map's edge repeats.
            out.fill(0.0);
            for row in y..=y + 2 * radius {
                let row = row.saturating_sub(radius).min(size.y - 1);
                inputs.simd.run_task(Add {
                    sum: &mut *out,
                    values: &kept[place(row)],
                });
            }
            inputs.simd.run_task(Scale {
                values: &mut *out,
                factor: self.uniforms.share,
            });
            inputs.simd.run_task(Store {
                encoding: self.encoding,
                texels: out,
            });
        }
    }

    fn tile(&self) -> Option<UVec2> {
        Some(self.uniforms.tile.as_uvec2())
    }
}

/// Elementwise addition of `values` to `sum`.
pub(super) struct Add<'a> {
    pub(super) sum: &'a mut [f32],
    pub(super) values: &'a [f32],
}

impl SimdTask for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (sum, value) in self.sum.iter_mut().zip(self.values) {
            *sum += value;
        }
    }
}

/// Elementwise multiplication by `factor`.
pub(super) struct Scale<'a> {
    pub(super) values: &'a mut [f32],
    pub(super) factor: f32,
}

impl SimdTask for Scale<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for value in self.values {
            *value *= self.factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filtering::moments::{
        exp2::power_of_two,
        of_depth::{centre_depth, power_moments},
    };
    use umbrage_core::{Format, Image, ImageDesc, Simd};

    fn depths(size: UVec2) -> Image {
        let desc = ImageDesc {
            label: "test",
            size,
            layers: 2,
            format: Format::R32,
        };
        let mut image = Image::filled_with(desc, 0.0);
        for (i, value) in image.texels.iter_mut().enumerate() {
            *value = 0.5 + 0.5 * (i as f32 * 0.37).sin();
        }
        image
    }

    /// Each texel is the mean of the moments of a square of depths, with a repeated edge.
    #[test]
    fn texels_are_means_of_squares() {
        let image = depths(UVec2::new(9, 7));
        for radius in [0, 1, 3, 20] {
            let kernel = kernel(MomentKind::Powers, radius);
            let got = run_kernel(&kernel, &image, 7);
            let r = radius as i32;
            for (x, y, layer) in [(0, 0, 0), (4, 3, 1), (8, 6, 1), (2, 5, 0)] {
                let mut expected = [0.0; 4];
                for dy in -r..=r {
                    for dx in -r..=r {
                        let (x, y) = ((x + dx).clamp(0, 8), (y + dy).clamp(0, 6));
                        let depth = image.view().load(x, y, layer);
                        for (sum, moment) in
                            expected.iter_mut().zip(power_moments(depth).to_array())
                        {
                            *sum += f64::from(moment);
                        }
                    }
                }
                let count = f64::from((2 * r + 1) * (2 * r + 1));
                let at = got.view().index(x, y, layer);
                for (got, sum) in got.texels[at..at + 4].iter().zip(expected) {
                    let off = f64::from(*got) - sum / count;
                    assert!(off.abs() < 1e-6, "radius {radius} at {x}, {y}: {off}");
                }
            }
        }
    }

    /// Rows computed together have the bits of rows computed one by one.
    #[test]
    fn parts_don_t_change_bits() {
        let image = depths(UVec2::new(17, 23));
        let kind = MomentKind::OneExponential { rising: 40.0 };
        for radius in [0, 2, 15] {
            let kernel = kernel(kind, radius);
            let one = run_kernel(&kernel, &image, 1);
            for rows in [2, 5, 23] {
                assert_eq!(run_kernel(&kernel, &image, rows).texels, one.texels);
            }
        }
        // Without a blur, texels are the moments themselves.
        let sharp = run_kernel(&kernel(kind, 0), &image, 23);
        let up = power_of_two(40.0 * centre_depth(image.texels[5]));
        assert_eq!(sharp.texels[10..12], [up, up * up]);
    }

    fn kernel(kind: MomentKind, radius: u32) -> MomentMapKernel {
        MomentMapKernel::new(kind, MomentPrecision::Bits32, radius, false)
    }

    /// Runs the kernel with this number of rows at a time.
    fn run_kernel(kernel: &MomentMapKernel, image: &Image, rows: usize) -> Image {
        let desc = ImageDesc {
            format: kernel.kind.format(MomentPrecision::Bits32),
            ..image.desc
        };
        let mut out = Image::filled_with(desc, 9.0);
        let row_len = desc.size.x as usize * desc.format.channels();
        let images = [image.view()];
        let inputs = Inputs {
            images: &images,
            simd: Simd::Native,
        };
        let layers = out.texels.chunks_mut(row_len * desc.size.y as usize);
        for (layer, texels) in (0..).zip(layers) {
            for (part, out) in texels.chunks_mut(row_len * rows).enumerate() {
                let first = (part * rows) as u32;
                kernel.filter_rows(&inputs, first, layer, row_len, out);
            }
        }
        out
    }
}
