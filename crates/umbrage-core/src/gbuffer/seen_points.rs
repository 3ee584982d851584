//! Receiving points in tiles of the image, with boxes around them, so that whole tiles can be
//! skipped.

use crate::{
    gbuffer::receivers::Receivers,
    geometry::{
        aabb::Aabb,
        box_tree::{BoxTree, RUN},
    },
    light_space::fit::frustum::SliceOfView,
    parallel::prelude::*,
};
use glam::Vec3;
use std::{ops::Range, sync::Arc};

/// Side of a tile, pixels. A tile is one run of the box tree.
const TILE: usize = 8;

const _: () = assert!(TILE * TILE == RUN as usize, "a tile is a run");

/// The shadow-receiving points of an image, tile by tile, tiles in rows from the top. Every tile
/// has [`RUN`] entries, one for each of its pixels, empty ones included.
#[derive(Clone, Debug)]
pub(crate) struct SeenPoints<'a> {
    receivers: &'a Receivers,
    tiles_across: usize,
    tree: Arc<BoxTree>,
    /// Slice of the view that contains the points; `None` for the whole view.
    slice: Option<SliceOfView>,
}

impl<'a> SeenPoints<'a> {
    /// Returns the points of valid receivers.
    pub(crate) fn new(receivers: &'a Receivers) -> Self {
        let width = receivers.size.x as usize;
        let height = receivers.size.y as usize;
        let tiles_across = width.div_ceil(TILE);
        let boxes_of_row = |row: usize| -> Vec<Aabb> {
            let columns = 0..tiles_across;
            columns
                .map(|column| box_of(receivers, column, row))
                .collect()
        };
        let rows = (0..height.div_ceil(TILE)).into_par_iter();
        let boxes: Vec<Vec<Aabb>> = rows.map(boxes_of_row).collect();
        Self {
            receivers,
            tiles_across,
            tree: Arc::new(BoxTree::new(boxes.concat())),
            slice: None,
        }
    }

    /// Returns the points within a slice of a camera's view.
    pub(crate) fn within_slice(&self, slice: SliceOfView) -> Self {
        let unboxed = Self {
            slice: Some(slice),
            ..self.clone()
        };
        let tile_count = self.entries().end / RUN;
        let mut boxes = vec![Aabb::EMPTY; tile_count as usize];
        let mut walk = self.tree.walk(self.entries());
        while let Some(block) = walk.next() {
            if block.bounds.is_empty() || slice.holds_none_of(&block.bounds) {
                continue;
            }
            let Some(tile) = &block.run else {
                walk.enter(&block);
                continue;
            };
            boxes[(tile.start / RUN) as usize] = if slice.holds_all_of(&block.bounds) {
                block.bounds
            } else {
                Aabb::from_points(unboxed.points_in(tile))
            };
        }
        Self {
            tree: Arc::new(BoxTree::new(boxes)),
            ..unboxed
        }
    }

    /// Returns the points of the receivers, with a tree built earlier.
    pub(crate) fn with_tree(receivers: &'a Receivers, tree: Arc<BoxTree>) -> Self {
        Self {
            receivers,
            tiles_across: (receivers.size.x as usize).div_ceil(TILE),
            tree,
            slice: None,
        }
    }

    /// Returns the tree of boxes around the tiles' points.
    pub(crate) fn tree(&self) -> &Arc<BoxTree> {
        &self.tree
    }

    /// Returns the range of all entries.
    pub(crate) fn entries(&self) -> Range<u32> {
        let tiles_down = (self.receivers.size.y as usize).div_ceil(TILE);
        0..(self.tiles_across * tiles_down) as u32 * RUN
    }

    /// Returns the world positions of a tile's points. `tile` is its range of entries.
    pub(crate) fn points_in(&self, tile: &Range<u32>) -> impl Iterator<Item = Vec3> + use<'a> {
        let index = (tile.start / RUN) as usize;
        let slice = self.slice;
        let points = points_in(
            self.receivers,
            index % self.tiles_across,
            index / self.tiles_across,
        );
        points.filter(move |&p| slice.is_none_or(|slice| slice.holds(p)))
    }
}

/// Returns the box around the points in a tile, given by its column and row among the tiles.
fn box_of(receivers: &Receivers, column: usize, row: usize) -> Aabb {
    let width = receivers.size.x as usize;
    let height = receivers.size.y as usize;
    // Handle tiles at the border of the image point by point.
    let is_cut_off = (column + 1) * TILE > width || (row + 1) * TILE > height;
    if is_cut_off {
        return Aabb::from_points(points_in(receivers, column, row));
    }
    let first = row * TILE * width + column * TILE;
    let mut around = Aabb::EMPTY;
    for (axis, all) in [&receivers.x, &receivers.y, &receivers.z]
        .into_iter()
        .enumerate()
    {
        // Reduce column by column, so that the loop is vectorised.
        let mut least = [f32::INFINITY; TILE];
        let mut greatest = [f32::NEG_INFINITY; TILE];
        for y in 0..TILE {
            let pixels = first + y * width..first + y * width + TILE;
            let values = &all[pixels.clone()];
            let receives = &receivers.receives[pixels];
            for i in 0..TILE {
                let low = if receives[i] {
                    values[i]
                } else {
                    f32::INFINITY
                };
                let high = if receives[i] {
                    values[i]
                } else {
                    f32::NEG_INFINITY
                };
                least[i] = least[i].min(low);
                greatest[i] = greatest[i].max(high);
            }
        }
        around.min[axis] = least.into_iter().fold(f32::INFINITY, f32::min);
        around.max[axis] = greatest.into_iter().fold(f32::NEG_INFINITY, f32::max);
    }
    around
}

/// Returns the world positions of the points in a tile, given by its column and row among the
/// tiles.
fn points_in(
    receivers: &Receivers,
    column: usize,
    row: usize,
) -> impl Iterator<Item = Vec3> + use<'_> {
    let width = receivers.size.x as usize;
    let height = receivers.size.y as usize;
    let columns = column * TILE..((column + 1) * TILE).min(width);
    let rows = row * TILE..((row + 1) * TILE).min(height);
    rows.flat_map(move |y| {
        let pixels = y * width + columns.start..y * width + columns.end;
        let positions = receivers.x[pixels.clone()]
            .iter()
            .zip(&receivers.y[pixels.clone()])
            .zip(&receivers.z[pixels.clone()]);
        positions
            .zip(&receivers.receives[pixels])
            .filter(|(_, receives)| **receives)
            .map(|(((&x, &y), &z), _)| Vec3::new(x, y, z))
    })
}
