//! Cells across the light, and tiles of them.
//!
//! Cells are the leaves of a quadtree: small where there are many small facets. They depend on the
//! facets and the sun alone. Facets wider than a cell that they overlap are computed cell by cell,
//! others in the cell of their centre. A tile is a run of cells that is computed at once. Sums are
//! in the order of cells, so that answers do not depend on tiles.

use crate::{morton, tree::Projected};
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// A cell is divided if it has more centres than this of facets that are no wider than its quarters.
/// Half or a fourth of it take as long.
const MOST_PER_CELL: usize = 1024;
/// Levels of squares below the whole.
const LEVELS: u32 = morton::BITS;
/// Bits of a facet's level, below its Morton code.
const LEVEL_BITS: u32 = 5;
const GREATEST_LEVEL: u32 = (1 << LEVEL_BITS) - 1;
/// Relative bound of the rounding of a box and of a query in the tree of facets: at most a step of
/// 32-bit numbers each, and as much to spare.
const TREE_ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Bound of how far facets extend beyond a square that contains their centre, per size: a half, and
/// more than the rounding of coordinates.
const GREATEST_EXTENT: f64 = 0.51;

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

/// Cells that are computed at once: those of some squares.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    pub(crate) cells: Range<u32>,
    /// Number of facets with centres in the squares.
    facets: usize,
    squares: Vec<TileSquare>,
}

/// A square of a tile.
#[derive(Clone, Debug)]
struct TileSquare {
    rectangle: Rectangle,
    /// Greatest extent of facets that are computed in it as a whole beyond the rectangle.
    reach: f64,
}

/// Square cells around all facets, and tiles of them.
#[derive(Debug)]
pub(crate) struct Grid {
    low: DVec2,
    side: f64,
    /// Bound of the rounding in the tree of facets.
    rounding: f64,
    /// Along the Morton curve.
    cells: Vec<Square>,
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
        let greatest = low.abs().max(high.abs()).max_element();
        let mut grid = Self {
            low,
            side: side.max(f64::MIN_POSITIVE),
            rounding: TREE_ROUNDING * greatest,
            cells: Vec::new(),
            tiles: Vec::new(),
        };
        let place = |row: u32| {
            let [low, high] = seen(row)?.bounds();
            let level = u64::from(grid.level_of([low, high]));
            Some(grid.code(low.midpoint(high)) << LEVEL_BITS | level)
        };
        // Rows that the sun doesn't see are last.
        let rows = (0..rows).into_par_iter();
        let mut places: Vec<u64> = rows.map(|row| place(row).unwrap_or(u64::MAX)).collect();
        places.par_sort_unstable();
        places.truncate(places.partition_point(|&place| place < u64::MAX));
        grid.divide(Square::WHOLE, &places, most_in_tile, false);
        grid
    }

    /// Adds the cells of a square, and adds squares of at most `most_in_tile` facets to tiles unless
    /// this one is in a tile. `places` are the codes and levels of the facets with centres in the
    /// square, rising.
    fn divide(&mut self, square: Square, places: &[u64], most_in_tile: usize, is_in_tile: bool) {
        let narrow_in_quarters = levels_from(square.level + 1, places).take(MOST_PER_CELL + 1);
        let is_cell = square.level == LEVELS || narrow_in_quarters.count() <= MOST_PER_CELL;
        let is_tile = !is_in_tile && (is_cell || places.len() <= most_in_tile);
        let first = self.cells.len() as u32;
        if is_cell {
            self.cells.push(square);
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
            self.add_to_tiles(square, first, places, most_in_tile);
        }
    }

    /// Adds a square, whose cells begin with `first`, to the last tile or to another one.
    fn add_to_tiles(&mut self, square: Square, first: u32, places: &[u64], most_in_tile: usize) {
        let cells = first..self.cells.len() as u32;
        // The widest facet that may be computed as a whole is as wide as the largest cell.
        let levels = self.cells[first as usize..].iter().map(|cell| cell.level);
        let largest_cell = levels.min().unwrap_or(0);
        let widest = levels_from(largest_cell, places)
            .min()
            .map_or(0.0, |level| self.side / f64::from(1_u32 << level));
        let square = TileSquare {
            rectangle: self.rectangle_of(square),
            reach: GREATEST_EXTENT * widest,
        };
        match self.tiles.last_mut() {
            Some(tile) if tile.facets + places.len() <= most_in_tile => {
                tile.cells.end = cells.end;
                tile.facets += places.len();
                tile.squares.push(square);
            }
            _ => self.tiles.push(Tile {
                cells,
                facets: places.len(),
                squares: vec![square],
            }),
        }
    }

    /// Returns the tiles in rising order.
    pub(crate) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Returns whether a facet may darken one that is computed in a tile, or be such a facet.
    pub(crate) fn is_in_tile(&self, facet: &Projected, tile: &Tile) -> bool {
        let [low, high] = facet.bounds();
        let bounds = [low - self.rounding, high + self.rounding];
        let mut squares = tile.squares.iter();
        squares.any(|square| self.is_in_square(bounds, square))
    }

    fn is_in_square(&self, bounds: Rectangle, square: &TileSquare) -> bool {
        let ([low, high], [least, most]) = (bounds, square.rectangle);
        let gap = (least - high).max(low - most).max_element();
        if gap <= 0.0 {
            return true;
        }
        if gap > square.reach {
            return false;
        }
        // Only facets of at most this level extend across the gap, over cells of at most their level:
        // see `key`. So the box must overlap such a cell. If it is narrower than the cell, a corner
        // is inside.
        let greatest_level = self.level_of_size(gap / GREATEST_EXTENT);
        self.level_of(bounds) <= greatest_level
            || corners_of(bounds)
                .into_iter()
                .any(|corner| self.cell_at(corner).level <= greatest_level)
    }

    /// Returns the Morton code of a place across the light.
    fn code(&self, place: DVec2) -> u64 {
        morton::code_2d((place - self.low) / self.side)
    }

    /// Returns the level of the smallest squares that are as wide as a box, at most
    /// `GREATEST_LEVEL`.
    fn level_of(&self, bounds: Rectangle) -> u32 {
        let [low, high] = bounds;
        self.level_of_size((high - low).max_element())
    }

    fn level_of_size(&self, size: f64) -> u32 {
        (self.side / size.max(f64::MIN_POSITIVE))
            .log2()
            .clamp(0.0, f64::from(GREATEST_LEVEL)) as u32
    }

    /// Returns the cell that contains a Morton code.
    fn cell_of(&self, code: u64) -> u32 {
        self.cells.partition_point(|cell| cell.code <= code) as u32 - 1
    }

    fn cell_at(&self, place: DVec2) -> Square {
        self.cells[self.cell_of(self.code(place)) as usize]
    }

    /// Returns the key by which facets are sorted, and the cell of a facet's centre. Facets that
    /// are computed cell by cell have the least keys. Keys rise as sizes fall, then along the curve.
    pub(crate) fn key(&self, facet: &Projected) -> (u64, u32) {
        let bounds = facet.bounds();
        let level = self.level_of(bounds);
        let [low, high] = bounds;
        let code = self.code(low.midpoint(high));
        let cell = self.cell_of(code);
        let square = self.cells[cell as usize];
        // A cell of at most the facet's level is as wide as the facet. If all corners are in such
        // cells, the facet overlaps no others. Most are in the centre's cell, which spares a search.
        let is_narrow = square.level <= level
            && corners_of(bounds).into_iter().all(|corner| {
                square.contains(self.code(corner)) || self.cell_at(corner).level <= level
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
        self.rectangle_of(self.cells[cell as usize])
    }

    fn rectangle_of(&self, square: Square) -> Rectangle {
        let corner = morton::place_2d(square.code);
        // Neighbours compute the same bits of their common side.
        let at = |step: u64| {
            let [x, y] = corner.map(|place| (place + step) as f64 / f64::from(1 << LEVELS));
            self.low + DVec2::new(x, y) * self.side
        };
        [at(0), at(1 << (LEVELS - square.level))]
    }
}

/// Returns the levels of facets, from a least one on.
fn levels_from(least: u32, places: &[u64]) -> impl Iterator<Item = u32> {
    let levels = places.iter().map(|place| *place as u32 & GREATEST_LEVEL);
    levels.filter(move |&level| level >= least)
}

fn corners_of(bounds: Rectangle) -> [DVec2; 4] {
    let [low, high] = bounds;
    [
        low,
        high,
        DVec2::new(low.x, high.y),
        DVec2::new(high.x, low.y),
    ]
}
