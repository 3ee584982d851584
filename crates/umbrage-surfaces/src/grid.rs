//! Cells across the light, and tiles of them.
//!
//! Cells depend on the facets and the sun alone. Facets wider than a cell are computed cell by
//! cell, others in the cell of their centre. A tile is a square of cells that is computed at once.
//! Sums are in the order of cells, so that answers do not depend on tiles.

use crate::{morton, tree::Projected};
use glam::DVec2;
use rayon::prelude::*;
use std::{
    ops::Range,
    sync::atomic::{AtomicU32, Ordering},
};

/// Facets per cell in the mean, within a factor of four.
const PER_CELL: f64 = 256.0;
/// Most bits of a cell's place along an axis.
const MOST_BITS: u32 = 8;
/// Bits of a Morton code: the lower part of a key.
const CODE_BITS: u32 = 42;

/// A rectangle across the light: least and greatest coordinates.
pub(crate) type Rectangle = [DVec2; 2];

/// Square cells around all facets. Cells are numbered along a Morton curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    low: DVec2,
    side: f64,
    /// There are 2^bits cells a side. Even: see [`Grid::is_wide`].
    bits: u32,
}

impl Grid {
    /// Returns the cells for this number of facets within bounds.
    pub(crate) fn new(bounds: Rectangle, facets: usize) -> Self {
        let [low, high] = bounds;
        // The greatest coordinate is inside, as ends of cells are outside.
        let side = (high - low).max_element() * (1.0 + 1e-9);
        let half_bits = (facets as f64 / PER_CELL).max(1.0).log2() / 4.0;
        Self {
            low,
            side: side.max(f64::MIN_POSITIVE),
            bits: (2 * half_bits.round() as u32).min(MOST_BITS),
        }
    }

    /// Returns the key of a facet: its class of size, then its centre along the curve. Large facets
    /// have the least keys.
    pub(crate) fn key(&self, facet: &Projected) -> u64 {
        let [low, high] = facet.bounds();
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        // Nodes are tight if their facets are of similar size: within a factor of four.
        let class = ((self.side / size).log2() / 2.0).clamp(0.0, 31.0) as u64;
        let centre = (low.midpoint(high) - self.low) * (morton::STEPS / self.side);
        class << CODE_BITS | morton::code_2d(centre.clamp(DVec2::ZERO, DVec2::splat(morton::STEPS)))
    }

    /// Returns whether the facet of a key is wider than a cell.
    pub(crate) fn is_wide(&self, key: u64) -> bool {
        key >> CODE_BITS < u64::from(self.bits / 2)
    }

    /// Returns the cell of a key's centre.
    pub(crate) fn cell_of(&self, key: u64) -> u32 {
        let code = key & ((1 << CODE_BITS) - 1);
        (code >> (CODE_BITS - 2 * self.bits)) as u32
    }

    /// Returns tiles in rising order that contain at most a number of facets' centres, or one cell.
    /// `seen` returns a row as the sun sees it.
    pub(crate) fn tiles(
        &self,
        rows: u32,
        most: u32,
        seen: &(impl Fn(u32) -> Option<Projected> + Sync),
    ) -> Vec<Tile> {
        let whole = Tile {
            first: 0,
            bits: self.bits,
        };
        if rows <= most {
            return vec![whole];
        }
        let counts: Vec<AtomicU32> = whole.cells().map(|_| AtomicU32::new(0)).collect();
        (0..rows)
            .into_par_iter()
            .filter_map(seen)
            .for_each(|facet| {
                let cell = self.cell_of(self.key(&facet));
                counts[cell as usize].fetch_add(1, Ordering::Relaxed);
            });
        let mut tiles = Vec::new();
        let mut stack = vec![whole];
        while let Some(tile) = stack.pop() {
            let counts = tile
                .cells()
                .map(|cell| counts[cell as usize].load(Ordering::Relaxed));
            if tile.bits == 0 || counts.sum::<u32>() <= most {
                tiles.push(tile);
                continue;
            }
            let bits = tile.bits - 1;
            // The last one is visited first.
            stack.extend((0..4).rev().map(|quarter| Tile {
                first: tile.first + (quarter << (2 * bits)),
                bits,
            }));
        }
        tiles
    }

    /// Returns the rectangle of a tile.
    pub(crate) fn rectangle(&self, tile: Tile) -> Rectangle {
        let place = |axis: u32| {
            (0..self.bits).fold(0, |place, bit| {
                place | (tile.first >> (2 * bit + axis) & 1) << bit
            })
        };
        let corner = [place(0), place(1)];
        // Neighbours compute the same bits of their common side.
        let at = |step: u32| {
            let [x, y] = corner.map(|place| f64::from(place + step) / f64::from(1 << self.bits));
            self.low + DVec2::new(x, y) * self.side
        };
        [at(0), at(1 << tile.bits)]
    }

    /// Returns the rectangle that contains the facets with centres in a tile, but for wide ones.
    pub(crate) fn with_halo(&self, tile: Tile) -> Rectangle {
        // Half a cell, and more than any rounding.
        let halo = DVec2::splat(0.51 * self.side / f64::from(1 << self.bits));
        let [low, high] = self.rectangle(tile);
        [low - halo, high + halo]
    }
}

/// A square of 4^bits cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    first: u32,
    bits: u32,
}

impl Tile {
    /// Returns the tile of a cell.
    pub(crate) fn of_cell(first: u32) -> Self {
        Self { first, bits: 0 }
    }

    /// Returns the cells along the curve.
    pub(crate) fn cells(&self) -> Range<u32> {
        self.first..self.first + (1 << (2 * self.bits))
    }
}
