//! Lower bound of blocker depths: a coarse grid over a map. Each cell holds the least depth of all
//! casters that may block part of the light for a receiver in it. These are the casters that appear
//! in front of the light from there.
//!
//! Guennebaud, Barthe and Paulin 2006, "Real-time soft shadow mapping by backprojection", bound the
//! search for blockers by a pyramid of least depths. Here this is done once per cell instead of
//! once per receiver. The bound holds for all receivers before the far plane. For a receiver at the
//! far plane, a caster at the depth z moves the light's edge by `1 - z` times the half axes of
//! [`LightExtent`]. It moves the edge less for nearer receivers. Gaps between cells count with
//! their least width.

use crate::{
    filtering::{
        least_depth::{LeastDepthKernel, LeastDepthUniforms},
        light_extent::{LIGHT_EXTENT, LightExtent, light_axes, reach_along},
        sample_pattern::PatternShape,
    },
    shadow_map::Maps,
};
use glam::{UVec2, Vec2};
use std::{ops::Range, sync::Arc};
use umbrage_core::{
    FilterKernel, Format, ImageDesc, ImageId, Inputs, Kernel, Module, SimdTask, UniformBlock,
    module, uniforms,
};

/// Maximum number of cells along a side. More cells separate casters better, but the cost grows
/// with the fourth power of their number.
const MAX_CELLS: u32 = 32;

/// Grid of square cells over a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cells {
    /// Side of the tiles that are reduced to one texel, texels. The reduction runs twice, so a
    /// cell's side is the square of this.
    ratio: u32,
    /// Number of cells along a side.
    pub(crate) count: u32,
}

impl Cells {
    /// Returns the grid over a map with this side, texels.
    pub(crate) fn over_size(size: u32) -> Self {
        // Use two even steps: a single reduction would read too many texels for each texel it
        // writes.
        let mut ratio = size.div_ceil(MAX_CELLS).isqrt().max(1);
        while ratio * ratio * MAX_CELLS < size {
            ratio += 1;
        }
        Self {
            ratio,
            count: size.div_ceil(ratio * ratio),
        }
    }

    /// Returns the side of a cell, texels.
    pub(crate) fn side(self) -> u32 {
        self.ratio * self.ratio
    }
}

/// Adds the images and filters of the grid to `maps`. Returns the image with the least depth in
/// each cell's reach. `size` is the map's side, texels; `packed` is whether its depths occupy four
/// channels.
pub(crate) fn add(
    maps: &mut Maps,
    size: u32,
    packed: bool,
    shape: PatternShape,
    extent: LightExtent,
) -> ImageId {
    // Describe the three filters.
    let cells = Cells::over_size(size);
    let tile_count = size.div_ceil(cells.ratio);
    let tile_kernel = LeastDepthKernel {
        uniforms: LeastDepthUniforms {
            ratio: cells.ratio,
            size,
        },
        packed,
    };
    let cell_kernel = LeastDepthKernel {
        uniforms: LeastDepthUniforms {
            ratio: cells.ratio,
            size: tile_count,
        },
        packed: false,
    };
    let reach_kernel = DepthInReachKernel {
        uniforms: DepthInReachUniforms {
            square: u32::from(shape == PatternShape::Square),
            cells: cells.count,
            cell: cells.side() as f32,
            half: size as f32 * 0.5,
            extent,
        },
    };
    // Chain them: map, tiles, cells, reach.
    let map = maps.map;
    let of_tiles = add_step(
        maps,
        map,
        "least depth of tiles",
        tile_count,
        Arc::new(tile_kernel),
    );
    let of_cells = add_step(
        maps,
        of_tiles,
        "least depth of cells",
        cells.count,
        Arc::new(cell_kernel),
    );
    add_step(
        maps,
        of_cells,
        "least depth in reach",
        cells.count,
        Arc::new(reach_kernel),
    )
}

/// Adds an image with this side, texels, and the filter that computes it from the image `input`.
fn add_step(
    maps: &mut Maps,
    input: ImageId,
    label: &'static str,
    side: u32,
    kernel: Arc<dyn FilterKernel>,
) -> ImageId {
    let output = maps.image(ImageDesc {
        label,
        size: UVec2::splat(side),
        layers: maps.images[maps.map].layers,
        format: Format::R32,
    });
    maps.filter(kernel, vec![input], output);
    output
}

uniforms! {
    /// Uniforms of [`DepthInReachKernel`].
    pub struct DepthInReachUniforms {
        /// Set to 1 if the light's projection is a parallelogram, 0 if it is an ellipse. It must be
        /// first: see
        /// [`layer_count`](crate::shadow_map::layers::ShadowMapUniforms::layer_count).
        pub square: u32,
        /// Number of cells along a side.
        pub cells: u32,
        /// Side of a cell, texels of the map.
        pub cell: f32,
        /// Half of the map's side, texels.
        pub half: f32,
        /// Extent of the light on the map.
        pub extent: LightExtent,
    }
}

/// Filter from the least depth in each cell to the least depth in its reach.
#[derive(Clone, Copy, Debug)]
pub struct DepthInReachKernel {
    uniforms: DepthInReachUniforms,
}

impl Kernel for DepthInReachKernel {
    fn modules(&self) -> Vec<Module> {
        let own = module!("depth_in_reach");
        vec![LIGHT_EXTENT, own]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl FilterKernel for DepthInReachKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let image = &inputs.images[0];
        let cells = self.uniforms.cells as usize;
        let first = image.index(0, 0, layer);
        inputs.simd.run_task(Row {
            kernel: self,
            depths: &image.texels[first..first + cells * cells],
            y: start.y as usize,
            layer: layer as usize,
            out,
        });
    }
}

/// Row of cells.
struct Row<'a> {
    kernel: &'a DepthInReachKernel,
    /// Least depth in each cell.
    depths: &'a [f32],
    y: usize,
    layer: usize,
    out: &'a mut [f32],
}

impl SimdTask for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let u = &self.kernel.uniforms;
        let nearest = self.depths.iter().copied().fold(1.0, f32::min);
        let max_difference = u.extent.half_axis_v[self.layer].w.min(1.0 - nearest);
        for x in 0..self.out.len() {
            let reach = self.kernel.cell_reach(x, self.y, self.layer);
            // Add a cell for rounding; no cell farther away is reached.
            let beyond = (reach.y * max_difference / u.cell) as usize + 2;
            let first = self.y.saturating_sub(beyond);
            let end = (self.y + beyond + 1).min(u.cells as usize);
            self.out[x] = self.least_in_reach(x, first..end, reach, max_difference);
        }
    }
}

impl Row<'_> {
    /// Returns the least depth in reach of cell `column` of this row, among the cells of these
    /// rows. `reach` is for a unit of clip depth. Differences of clip depths are limited to
    /// `max_difference`.
    #[inline(always)]
    fn least_in_reach(
        &self,
        column: usize,
        rows: Range<usize>,
        reach: Vec2,
        max_difference: f32,
    ) -> f32 {
        let u = &self.kernel.uniforms;
        let mut across = [0.0; MAX_CELLS as usize];
        for (x, across) in across.iter_mut().enumerate() {
            *across = gap(column, x, u.cell);
        }
        // One value per column, so that columns are lanes.
        let mut least = [1.0; MAX_CELLS as usize];
        for y in rows {
            let down = gap(self.y, y, u.cell);
            let row = &self.depths[y * u.cells as usize..][..u.cells as usize];
            for ((least, &across), &depth) in least.iter_mut().zip(&across).zip(row) {
                // Assume the receiver at the far plane, where the light's edge moves farthest.
                let nearer = if 1.0 - depth < max_difference {
                    1.0 - depth
                } else {
                    max_difference
                };
                let reached = (across <= reach.x * nearer) & (down <= reach.y * nearer);
                let depth = if reached { depth } else { 1.0 };
                *least = if depth < *least { depth } else { *least };
            }
        }
        least.into_iter().fold(1.0, f32::min)
    }
}

/// Returns the gap between two columns or two rows of cells with this side, texels; 0 for
/// neighbours.
#[inline(always)]
fn gap(a: usize, b: usize, side: f32) -> f32 {
    a.abs_diff(b).saturating_sub(1) as f32 * side
}

impl DepthInReachKernel {
    /// Returns the greatest distance of the light's edge from any receiver in cell (x, y), right
    /// and down, texels per unit of clip depth. The half axes are convex over the map, so their
    /// maxima are at the cell's corners.
    #[inline(always)]
    fn cell_reach(&self, x: usize, y: usize, layer: usize) -> Vec2 {
        let u = &self.uniforms;
        let mut reach = Vec2::ZERO;
        for corner in 0..4 {
            let column = x + (corner & 1);
            let row = y + (corner >> 1);
            let from_middle = Vec2::new(
                column as f32 * u.cell - u.half,
                row as f32 * u.cell - u.half,
            );
            let axes = light_axes(
                u.extent.half_axis_u[layer],
                u.extent.half_axis_v[layer],
                from_middle,
            );
            reach = reach.max(reach_along(u.square, axes));
        }
        reach
    }
}

#[cfg(test)]
#[path = "depth_in_reach_tests.rs"]
mod tests;
