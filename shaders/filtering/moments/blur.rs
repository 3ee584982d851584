//! Box filter along one axis. Two passes compute the mean of a square of texels.

use crate::filtering::moments::stored::{Encoding, Load, Store};
use glam::{IVec2, UVec2};
use std::borrow::Cow;
use umbrage_core::{
    FilterKernel, ImageView, Inputs, Kernel, Module, SimdTask, UniformBlock, module, uniforms,
};

uniforms! {
    /// Uniforms of [`BoxBlurKernel`].
    pub struct BoxBlurUniforms {
        /// Number of texels on each side.
        pub radius: i32,
        /// (1, 0) along rows, (0, 1) along columns.
        pub step: IVec2,
        /// Weight of each texel: one over their number.
        pub share: f32,
    }
}

/// Filter to an image of the same size and format. Each texel becomes the mean of the texels up to
/// `radius` away in its row or column. The image's edge repeats. Sums run from left to right, or
/// from top to bottom.
#[derive(Clone, Copy, Debug)]
pub struct BoxBlurKernel {
    /// Encoding in which channels are averaged.
    encoding: Encoding,
    /// Uniforms.
    pub uniforms: BoxBlurUniforms,
}

impl BoxBlurKernel {
    /// Returns the filter along rows for moments in this encoding.
    pub(crate) fn along_rows(radius: u32, encoding: Encoding) -> Self {
        Self::along_step(IVec2::X, radius, encoding)
    }

    /// Returns the filter along columns.
    pub(crate) fn along_columns(radius: u32, encoding: Encoding) -> Self {
        Self::along_step(IVec2::Y, radius, encoding)
    }

    fn along_step(step: IVec2, radius: u32, encoding: Encoding) -> Self {
        let share = 1.0 / (2 * radius + 1) as f32;
        Self {
            encoding: encoding.of_means(),
            uniforms: BoxBlurUniforms {
                radius: radius as i32,
                step,
                share,
            },
        }
    }
}

impl Kernel for BoxBlurKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = self.encoding.modules();
        modules.push(module!("blur"));
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl FilterKernel for BoxBlurKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let BoxBlurUniforms {
            radius,
            step,
            share,
        } = self.uniforms;
        let image = &inputs.images[0];
        let y = start.y as i32;
        out.fill(0.0);
        // Sum the texels along a row, or the rows of a column.
        if step == IVec2::X {
            let row = loaded_row(inputs, self.encoding, y, layer);
            let padded = padded_row(&row, image.desc.format.channels(), radius);
            let channels = image.desc.format.channels();
            for first in (0..=2 * radius as usize).map(|i| i * channels) {
                inputs.simd.run_task(Add {
                    sum: out,
                    values: &padded[first..],
                });
            }
        } else {
            let last = image.desc.size.y as i32 - 1;
            for i in -radius..=radius {
                let row = loaded_row(inputs, self.encoding, (y + i).clamp(0, last), layer);
                inputs.simd.run_task(Add {
                    sum: out,
                    values: &row,
                });
            }
        }
        // Turn sums into means, and encode them.
        inputs.simd.run_task(Scale {
            values: &mut *out,
            factor: share,
        });
        inputs.simd.run_task(Store {
            encoding: self.encoding,
            texels: out,
        });
    }
}

/// Returns a row of the first input, decoded for averaging.
pub(super) fn loaded_row<'a>(
    inputs: &Inputs<'a>,
    encoding: Encoding,
    y: i32,
    layer: u32,
) -> Cow<'a, [f32]> {
    let row = row(&inputs.images[0], y, layer);
    if encoding == Encoding::Floats {
        return Cow::Borrowed(row);
    }
    let mut texels = row.to_vec();
    inputs.simd.run_task(Load {
        encoding,
        texels: &mut texels,
    });
    Cow::Owned(texels)
}

/// Returns a row of a layer, with interleaved channels.
fn row<'a>(image: &ImageView<'a>, y: i32, layer: u32) -> &'a [f32] {
    let first = image.index(0, y, layer);
    &image.texels[first..first + image.desc.size.x as usize * image.desc.format.channels()]
}

/// Returns a row with `radius` additional copies of its first and last texel on either side.
fn padded_row(row: &[f32], channels: usize, radius: i32) -> Vec<f32> {
    let radius = radius as usize;
    let (first, last) = (&row[..channels], &row[row.len() - channels..]);
    [&first.repeat(radius), row, &last.repeat(radius)].concat()
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
    use umbrage_core::{Format, Image, ImageDesc, Simd};

    /// Both passes together compute the mean of a square of texels, with a repeated edge.
    #[test]
    fn two_passes_are_the_mean_of_a_square() {
        let desc = ImageDesc {
            label: "test",
            size: UVec2::new(9, 7),
            layers: 2,
            format: Format::Rg32,
        };
        let mut image = Image::filled_with(desc, 0.0);
        for (i, value) in image.texels.iter_mut().enumerate() {
            *value = (i as f32 * 0.37).sin();
        }
        for radius in [0, 1, 3, 20] {
            let rows = run_kernel(&BoxBlurKernel::along_rows(radius, Encoding::Floats), &image);
            let both = run_kernel(
                &BoxBlurKernel::along_columns(radius, Encoding::Floats),
                &rows,
            );
            let r = radius as i32;
            for (x, y, layer) in [(0, 0, 0), (4, 3, 1), (8, 6, 1), (2, 5, 0)] {
                let mut expected = [0.0; 2];
                for dy in -r..=r {
                    for dx in -r..=r {
                        let at =
                            image
                                .view()
                                .index((x + dx).clamp(0, 8), (y + dy).clamp(0, 6), layer);
                        expected[0] += f64::from(image.texels[at]);
                        expected[1] += f64::from(image.texels[at + 1]);
                    }
                }
                let count = f64::from((2 * r + 1) * (2 * r + 1));
                let at = both.view().index(x, y, layer);
                for (got, sum) in both.texels[at..at + 2].iter().zip(expected) {
                    let off = f64::from(*got) - sum / count;
                    assert!(off.abs() < 1e-6, "radius {radius} at {x}, {y}: {off}");
                }
            }
        }
    }

    fn run_kernel(kernel: &BoxBlurKernel, image: &Image) -> Image {
        let mut out = Image::filled_with(image.desc, 9.0);
        let row = image.desc.size.x as usize * image.desc.format.channels();
        let images = [image.view()];
        let inputs = Inputs {
            images: &images,
            simd: Simd::Native,
        };
        for (i, out) in out.texels.chunks_exact_mut(row).enumerate() {
            let height = image.desc.size.y as usize;
            let start = UVec2::new(0, (i % height) as u32);
            kernel.filter(&inputs, start, (i / height) as u32, out);
        }
        out
    }
}
