//! How near to the light the first blocker may be: a coarse grid over a map. Each cell holds the least depth of what may hide
//! some of the light from a receiver in it: of the casters that lie, seen from there, before the light.
//!
//! Guennebaud, Barthe and Paulin 2006, "Real-time soft shadow mapping by backprojection", bound the search for blockers by a
//! pyramid of least depths; here that is done once for each cell instead of once for each receiver. The bound holds for all
//! receivers before the far plane: with a receiver at the far plane, a caster at the depth z moves the light's rim by
//! `1 - z` times the half axes of [`LightExtent`], and less with one before it. Gaps between cells count as no wider than
//! they are anywhere.

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
    uniforms,
};

/// Most cells along a side. More tell casters apart better, but the work grows with their fourth power.
const MOST_CELLS: u32 = 32;

/// How a grid of cells lies over a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cells {
    /// Side of the tiles that are reduced to a texel, twice.
    ratio: u32,
    /// Cells along a side.
    pub(crate) count: u32,
}

impl Cells {
    /// Over a map of `size` texels.
    pub(crate) fn over(size: u32) -> Self {
        // Two even steps rather than one: a single reduction would read too many texels for each it writes.
        let mut ratio = size.div_ceil(MOST_CELLS).isqrt().max(1);
        while ratio * ratio * MOST_CELLS < size {
            ratio += 1;
        }
        Self {
            ratio,
            count: size.div_ceil(ratio * ratio),
        }
    }

    /// Side of a cell, texels.
    pub(crate) fn side(self) -> u32 {
        self.ratio * self.ratio
    }
}

/// Adds the grid to what makes a map of `size` texels.
pub(crate) fn add(
    maps: &mut Maps,
    (size, packed): (u32, bool),
    shape: PatternShape,
    extent: LightExtent,
) -> ImageId {
    let (cells, map) = (Cells::over(size), maps.map);
    let layers = maps.images[map].layers;
    let image = |label, side| ImageDesc {
        label,
        size: UVec2::splat(side),
        layers,
        format: Format::R32,
    };
    let tiles = size.div_ceil(cells.ratio);
    let least = |size, packed| LeastDepthKernel {
        uniforms: LeastDepthUniforms {
            ratio: cells.ratio,
            size,
        },
        packed,
    };
    let uniforms = DepthInReachUniforms {
        square: u32::from(shape == PatternShape::Square),
        cells: cells.count,
        cell: cells.side() as f32,
        half: size as f32 * 0.5,
        extent,
    };
    let steps: [(_, _, Arc<dyn FilterKernel>); 3] = [
        ("least depth of tiles", tiles, Arc::new(least(size, packed))),
        (
            "least depth of cells",
            cells.count,
            Arc::new(least(tiles, false)),
        ),
        (
            "least depth in reach",
            cells.count,
            Arc::new(DepthInReachKernel { uniforms }),
        ),
    ];
    steps.into_iter().fold(map, |input, (label, side, kernel)| {
        let output = maps.image(image(label, side));
        maps.filter(kernel, vec![input], output);
        output
    })
}

uniforms! {
    /// Uniforms of [`DepthInReachKernel`].
    pub struct DepthInReachUniforms {
        /// 1 if the light is a square's image, 0 if it is a disc's. It comes first: see
        /// [`ShadowMapUniforms::layer_count`](crate::shadow_map::layers::ShadowMapUniforms::layer_count).
        pub square: u32,
        /// Cells along a side.
        pub cells: u32,
        /// Side of a cell, texels of the map.
        pub cell: f32,
        /// Half of the map's side, texels.
        pub half: f32,
        /// The light on the map.
        pub extent: LightExtent,
    }
}

/// From the least depth in each cell to the least depth in its reach.
#[derive(Clone, Copy, Debug)]
pub struct DepthInReachKernel {
    uniforms: DepthInReachUniforms,
}

impl Kernel for DepthInReachKernel {
    fn modules(&self) -> Vec<Module> {
        let own = Module {
            name: "depth_in_reach",
            text: include_str!("depth_in_reach.wgsl"),
        };
        vec![LIGHT_EXTENT, own]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl FilterKernel for DepthInReachKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let (image, cells) = (&inputs.images[0], self.uniforms.cells as usize);
        let first = image.index(0, 0, layer);
        let depths = &image.texels[first..first + cells * cells];
        let (y, layer) = (start.y as usize, layer as usize);
        inputs.simd.run_task(Row {
            kernel: self,
            depths,
            y,
            layer,
            out,
        });
    }
}

/// A row of cells.
struct Row<'a> {
    kernel: &'a DepthInReachKernel,
    /// The least depth in each cell.
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
        let most = u.extent.half_axis_v[self.layer].w.min(1.0 - nearest);
        for x in 0..self.out.len() {
            let reach = self.kernel.cell_reach([x, self.y], self.layer);
            // No cell beyond is reached; one more makes up for rounding.
            let rows = (reach.y * most / u.cell) as usize + 2;
            let rows = self.y.saturating_sub(rows)..(self.y + rows + 1).min(u.cells as usize);
            self.out[x] = self.least_in_reach(rows, [x, self.y], reach, most);
        }
    }
}

impl Row<'_> {
    #[inline(always)]
    fn least_in_reach(&self, rows: Range<usize>, cell: [usize; 2], reach: Vec2, most: f32) -> f32 {
        let u = &self.kernel.uniforms;
        let gap = |a: usize, b: usize| a.abs_diff(b).saturating_sub(1) as f32 * u.cell;
        let mut across = [0.0; MOST_CELLS as usize];
        for (x, across) in across.iter_mut().enumerate() {
            *across = gap(cell[0], x);
        }
        // One a column, so that columns are lanes.
        let mut least = [1.0; MOST_CELLS as usize];
        for y in rows {
            let down = gap(cell[1], y);
            let row = &self.depths[y * u.cells as usize..][..u.cells as usize];
            for ((least, &across), &depth) in least.iter_mut().zip(&across).zip(row) {
                let nearer = if 1.0 - depth < most {
                    1.0 - depth
                } else {
                    most
                };
                let reached = (across <= reach.x * nearer) & (down <= reach.y * nearer);
                let depth = if reached { depth } else { 1.0 };
                *least = if depth < *least { depth } else { *least };
            }
        }
        least.into_iter().fold(1.0, f32::min)
    }
}

impl DepthInReachKernel {
    /// How far the light's rim lies from any receiver in a cell, right and down, for a unit of clip depth. The half axes are
    /// convex over the map, so the corners tell.
    #[inline(always)]
    fn cell_reach(&self, [x, y]: [usize; 2], layer: usize) -> Vec2 {
        let u = &self.uniforms;
        let at = |i: usize| i as f32 * u.cell - u.half;
        [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
            .into_iter()
            .fold(Vec2::ZERO, |most, (x, y)| {
                let axes = light_axes(
                    u.extent.half_axis_u[layer],
                    u.extent.half_axis_v[layer],
                    Vec2::new(at(x), at(y)),
                );
                most.max(reach_along(u.square, axes))
            })
    }
}

#[cfg(test)]
#[path = "depth_in_reach_tests.rs"]
mod tests;
