//! Levels of a mipmapped moment map. All are means of the first level, computed in two filters:
//! along rows, then along columns. One image holds all levels from 1 on, so that a kernel
//! reads two images for any number of levels.

use crate::filtering::moments::{
    blur::{Add, Scale},
    mipmaps::level_side,
    stored::{Encoding, Load, Store},
};
use glam::UVec2;
use std::borrow::Cow;
use umbrage_core::{
    FilterKernel, ImageView, Inputs, Kernel, Module, SimdTask, UniformBlock, module, uniforms,
};

uniforms! {
    /// Uniforms of the halving filter.
    pub struct HalveUniforms {
        /// Number of levels beyond the first.
        pub levels: i32,
        /// 0 along rows, 1 along columns.
        pub along_columns: u32,
    }
}

/// Filter that averages runs of 2, 4, 8 and so on texels.
///
/// Along rows it converts a square image to rows of all levels, next to each other, finest first.
/// Along columns it converts those to the levels, one below the other. A level's side is that of
/// the map, halved and rounded down. If it is odd, the last row and column are not in any texel of
/// the level. Sums run from left to right, or from top to bottom. Texels outside all levels are 0.
#[derive(Clone, Copy, Debug)]
pub struct HalveKernel {
    /// Encoding in which channels are averaged.
    encoding: Encoding,
    /// Uniforms.
    pub uniforms: HalveUniforms,
}

impl HalveKernel {
    /// Returns the filter along rows for moments in this encoding.
    pub(crate) fn along_rows(levels: u32, encoding: Encoding) -> Self {
        Self {
            encoding: encoding.of_means(),
            uniforms: HalveUniforms {
                levels: levels as i32,
                along_columns: 0,
            },
        }
    }

    /// Returns the filter along columns.
    pub(crate) fn along_columns(levels: u32, encoding: Encoding) -> Self {
        let mut kernel = Self::along_rows(levels, encoding);
        kernel.uniforms.along_columns = 1;
        kernel
    }

    fn average_row(&self, inputs: &Inputs<'_>, y: u32, layer: u32, out: &mut [f32]) {
        let image = &inputs.images[0];
        let row = loaded_row(inputs, self.encoding, y as i32, layer);
        let channels = image.desc.format.channels();
        let mut rest = out;
        for level in 1..=self.uniforms.levels as u32 {
            let side = level_side(image.desc.size.y, level) as usize;
            let (means, after) = rest.split_at_mut(side * channels);
            inputs.simd.run_task(MeansOfRuns {
                row: &row,
                channels,
                count: 1 << level,
                means,
            });
            rest = after;
        }
    }

    fn average_column(&self, inputs: &Inputs<'_>, y: u32, layer: u32, out: &mut [f32]) {
        let image = &inputs.images[0];
        let channels = image.desc.format.channels();
        let size = image.desc.size.y;
        let mut start = 0;
        for level in 1..=self.uniforms.levels as u32 {
            let side = level_side(size, level);
            if y < start + side {
                let count = 1 << level;
                let first = (y - start) * count;
                let means = &mut out[..side as usize * channels];
                for row in first..first + count {
                    let row = loaded_row(inputs, self.encoding, row as i32, layer);
                    inputs.simd.run_task(Add {
                        sum: &mut *means,
                        values: &row[start as usize * channels..],
                    });
                }
                inputs.simd.run_task(Scale {
                    values: means,
                    factor: 1.0 / count as f32,
                });
                return;
            }
            start += side;
        }
    }
}

impl Kernel for HalveKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = self.encoding.modules();
        modules.push(module!("halve"));
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl FilterKernel for HalveKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        out.fill(0.0);
        if self.uniforms.along_columns == 0 {
            self.average_row(inputs, start.y, layer, out);
        } else {
            self.average_column(inputs, start.y, layer, out);
        }
        inputs.simd.run_task(Store {
            encoding: self.encoding,
            texels: out,
        });
    }
}

/// Returns a row of the first input, decoded for averaging.
fn loaded_row<'a>(inputs: &Inputs<'a>, encoding: Encoding, y: i32, layer: u32) -> Cow<'a, [f32]> {
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

/// Means of runs of `count` texels of a row.
struct MeansOfRuns<'a> {
    row: &'a [f32],
    channels: usize,
    count: usize,
    means: &'a mut [f32],
}

impl SimdTask for MeansOfRuns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let share = 1.0 / self.count as f32;
        let runs = self.row.chunks_exact(self.count * self.channels);
        for (mean, run) in self.means.chunks_exact_mut(self.channels).zip(runs) {
            for texel in run.chunks_exact(self.channels) {
                for (sum, value) in mean.iter_mut().zip(texel) {
                    *sum += value;
                }
            }
            for sum in mean {
                *sum *= share;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filtering::moments::mipmaps::level_start;
    use umbrage_core::{Format, Image, ImageDesc, Simd};

    fn run_kernel(kernel: &HalveKernel, image: &Image, size: UVec2) -> Image {
        let desc = ImageDesc { size, ..image.desc };
        let mut out = Image::filled_with(desc, 9.0);
        let images = [image.view()];
        let inputs = Inputs {
            images: &images,
            simd: Simd::Native,
        };
        let row = size.x as usize * desc.format.channels();
        for (i, out) in out.texels.chunks_exact_mut(row).enumerate() {
            let start = UVec2::new(0, i as u32 % size.y);
            kernel.filter(&inputs, start, i as u32 / size.y, out);
        }
        out
    }

    /// Every texel of every level is the mean of its square of texels, in its own layer. Odd sides
    /// are included.
    #[test]
    fn levels_are_means_of_squares() {
        for size in [32, 43] {
            let desc = ImageDesc {
                label: "test",
                size: UVec2::splat(size),
                layers: 2,
                format: Format::Rg32,
            };
            let mut image = Image::filled_with(desc, 0.0);
            for (i, value) in image.texels.iter_mut().enumerate() {
                *value = (i as f32 * 0.37).sin();
            }
            let levels = 3;
            let along_rows = HalveKernel::along_rows(levels, Encoding::Floats);
            let rows = run_kernel(&along_rows, &image, desc.size);
            let height = level_start(size, levels + 1);
            let along_columns = HalveKernel::along_columns(levels, Encoding::Floats);
            let got = run_kernel(&along_columns, &rows, UVec2::new(size / 2, height));
            for level in 1..=levels {
                let side = level_side(size, level);
                let count = 1 << level;
                for (layer, x, y) in (0..2)
                    .flat_map(|layer| (0..side).map(move |x| (layer, x)))
                    .flat_map(|(layer, x)| (0..side).map(move |y| (layer, x, y)))
                {
                    let mut sum = 0.0;
                    for dy in 0..count {
                        for dx in 0..count {
                            let (x, y) = (x * count + dx, y * count + dy);
                            let at = image.view().index(x as i32, y as i32, layer);
                            sum += f64::from(image.texels[at + 1]);
                        }
                    }
                    let expected = sum / f64::from(count * count);
                    let row = level_start(size, level) + y;
                    let at = got.view().index(x as i32, row as i32, layer);
                    let off = f64::from(got.texels[at + 1]) - expected;
                    assert!(off.abs() < 1e-6, "level {level} at {x}, {y}: {off}");
                }
            }
        }
    }
}
