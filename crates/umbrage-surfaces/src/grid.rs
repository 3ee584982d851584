//! Cells across the light, and tiles of them.
//!
//! Cells are the leaves of a quadtree: small where there are many small facets. They depend on the
//! facets and the sun alone. Facets wider than a cell that they overlap are computed cell by cell,
//! others in the cell of their centre. A tile is a square of cells that is computed at once. Sums
//! are in the order of cells, so that answers do not depend on tiles.

use crate::{morton, tree::Projected};
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// A cell is divided if it has more facets than this that are no wider than its quarters.
const MOST_PER_CELL: usize = 1024;
/// Levels of squares below the whole: bits of a coordinate in a Morton code.
const LEVELS: u32 = 21;
/// Bits of a facet's level, below its Morton code.
const LEVEL_BITS: u32 = 5;

/// A rectangle across the light: least and greatest coordinates.
pub(crate) type Rectangle = [DVec2; 2];

/// A square of a quadtree.
#[derive(Clone, Copy, Debug)]
struct Square {
    /// Morton code of its low corner.
    code: u64,
    /// Its side is that of the whole, halved this many times.
    level: u32,
}

impl Square {
    const WHOLE: Self = Self { code: 0, level: 0 };

    /// Returns the number of codes inside.
    fn codes(self) -> u64 {
        1 << (2 * (LEVELS - self.level))
    }

    fn contains(self, code: u64) -> bool {
        (self.code..self.code + self.codes()).contains(&code)
    }

    /// Returns the quarters along the Morton curve.
    fn quarters(self) -> [Self; 4] {
        [0, 1, 2, 3].map(|quarter| Self {
            code: self.code + quarter * (self.codes() / 4),
            level: self.level + 1,
        })
    }
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    square: Square,
    /// Least level of the facets that are no wider than the cell, with centres in it.
    least_level: u32,
}

/// A square of cells.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    square: Square,
    pub(crate) cells: Range<u32>,
}

/// Square cells around all facets, and tiles of them.
#[derive(Debug)]
pub(crate) struct Grid {
    low: DVec2,
    side: f64,
    /// Along the Morton curve.
    cells: Vec<Cell>,
    tiles: Vec<Tile>,
}

impl Grid {
    /// Returns the cells for facets within bounds, and tiles that contain at most a number of
    /// facets' centres, or one cell. `seen` returns one of `rows` facets as the sun sees it.
    pub(crate) fn new(
        bounds: Rectangle,
        rows: u32,
        most_in_tile: usize,
        seen: &(impl Fn(u32) -> Option<Projected> + Sync),
    ) -> Self {
        let [low, high] = bounds;
        // The greatest coordinate is inside, as ends of cells are outside.
        let side = (high - low).max_element() * (1.0 + 1e-9);
        let mut grid = Self {
            low,
            side: side.max(f64::MIN_POSITIVE),
            cells: Vec::new(),
            tiles: Vec::new(),
        };
        let place_and_level = |facet: Projected| {
            let [low, high] = facet.bounds();
            grid.code(low.midpoint(high)) << LEVEL_BITS | u64::from(grid.level_of([low, high]))
        };
        let facets = (0..rows).into_par_iter().filter_map(seen);
        let mut places: Vec<u64> = facets.map(place_and_level).collect();
        places.par_sort_unstable();
        grid.divide(Square::WHOLE, &places, most_in_tile, false);
        grid
    }

    /// Adds the cells of a square, and its tiles unless it is in one. `places` are the codes and
    /// levels of the facets with centres in the square, rising.
    fn divide(&mut self, square: Square, places: &[u64], most_in_tile: usize, is_in_tile: bool) {
        let levels_from = |least: u32| {
            let levels = places
                .iter()
                .map(|place| (place % (1 << LEVEL_BITS)) as u32);
            levels.filter(move |&level| level >= least)
        };
        let narrow_in_quarters = levels_from(square.level + 1);
        let is_cell = square.level == LEVELS
            || narrow_in_quarters.take(MOST_PER_CELL + 1).count() <= MOST_PER_CELL;
        let is_tile = !is_in_tile && (is_cell || places.len() <= most_in_tile);
        let first = self.cells.len() as u32;
        if is_cell {
            let least_level = levels_from(square.level).min().unwrap_or(31);
            self.cells.push(Cell {
                square,
                least_level,
            });
        } else {
            let mut rest = places;
            for quarter in square.quarters() {
                let end = quarter.code + quarter.codes();
                let inside = rest.partition_point(|place| place >> LEVEL_BITS < end);
                let (places, after) = rest.split_at(inside);
                self.divide(quarter, places, most_in_tile, is_in_tile || is_tile);
                rest = after;
            }
        }
        if is_tile {
            let cells = first..self.cells.len() as u32;
            self.tiles.push(Tile { square, cells });
        }
    }

    /// Returns the tiles in rising order.
    pub(crate) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Returns the Morton code of a place across the light.
    fn code(&self, place: DVec2) -> u64 {
        let steps = f64::from(1 << LEVELS);
        let place = (place - self.low) * (steps / self.side);
        morton::code_2d(place.clamp(DVec2::ZERO, DVec2::splat(steps - 1.0)))
    }

    /// Returns the level of the smallest squares that are as wide as a box, 0..=31.
    fn level_of(&self, [low, high]: Rectangle) -> u32 {
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        (self.side / size).log2().clamp(0.0, 31.0) as u32
    }

    /// Returns the cell that contains a Morton code.
    fn cell_of(&self, code: u64) -> u32 {
        self.cells.partition_point(|cell| cell.square.code <= code) as u32 - 1
    }

    /// Returns the key by which facets are sorted, and the cell of a facet's centre. Facets that
    /// are computed cell by cell have the least keys. Keys rise as sizes fall, then along the curve.
    pub(crate) fn key(&self, facet: &Projected) -> (u64, u32) {
        let bounds = facet.bounds();
        let level = self.level_of(bounds);
        let [low, high] = bounds;
        let code = self.code(low.midpoint(high));
        let cell = self.cell_of(code);
        let corners = [
            low,
            high,
            DVec2::new(low.x, high.y),
            DVec2::new(high.x, low.y),
        ];
        // The box has a corner in each square of its level that it overlaps. Cells with other parts
        // of that square are as wide if the cell with the corner is.
        let is_narrow = corners.into_iter().all(|corner| {
            let code = self.code(corner);
            let mut square = self.cells[cell as usize].square;
            if !square.contains(code) {
                square = self.cells[self.cell_of(code) as usize].square;
            }
            square.level <= level
        });
        // Nodes are tight if their facets are of similar size: within a factor of four.
        let class = u64::from(level / 2);
        let key = u64::from(is_narrow) << 63 | class << (2 * LEVELS) | code;
        (key, cell)
    }

    /// Returns whether the facet of a key is computed as a whole.
    pub(crate) fn is_narrow(key: u64) -> bool {
        key >> 63 != 0
    }

    /// Returns the rectangle of a cell.
    pub(crate) fn rectangle(&self, cell: u32) -> Rectangle {
        self.rectangle_of(self.cells[cell as usize].square)
    }

    fn rectangle_of(&self, square: Square) -> Rectangle {
        let place = |axis: u32| {
            (0..LEVELS).fold(0, |place, bit| {
                place | (square.code >> (2 * bit + axis) & 1) << bit
            })
        };
        let corner = [place(0), place(1)];
        // Neighbours compute the same bits of their common side.
        let at = |step: u64| {
            let [x, y] = corner.map(|place| (place + step) as f64 / f64::from(1 << LEVELS));
            self.low + DVec2::new(x, y) * self.side
        };
        [at(0), at(1 << (LEVELS - square.level))]
    }

    /// Returns the rectangle that contains the facets with centres in a tile, but for wide ones.
    pub(crate) fn with_halo(&self, tile: &Tile) -> Rectangle {
        let Range { start, end } = tile.cells;
        let cells = &self.cells[start as usize..end as usize];
        let least_level = cells.iter().map(|cell| cell.least_level).min();
        let widest = self.side / f64::from(1_u32 << least_level.unwrap_or(0));
        // Half of the widest facet, and more than any rounding.
        let halo = DVec2::splat(0.51 * widest);
        let [low, high] = self.rectangle_of(tile.square);
        [low - halo, high + halo]
    }
}
