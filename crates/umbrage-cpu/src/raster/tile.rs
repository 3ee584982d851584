//! Tiles: the part of the image that one thread fills at a time, copied to a small buffer that stays in the nearest cache.

use super::bin::TILE;
use super::fill::{LANES, TINY_ROWS};
use umbrage_core::NO_TRIANGLE;

/// Floats between rows of a tile's buffer: lanes may run over a row's right end, into what is never copied out.
pub(crate) const STRIDE: usize = TILE + LANES;

/// A tile that is being filled.
#[derive(Debug)]
pub(crate) struct TileBuffer {
    /// Depth; spare rows at the end take what is drawn below the tile, and let every row be followed by a whole stride.
    pub(crate) depth: Vec<f32>,
    /// Triangle ids, if asked for.
    pub(crate) ids: Vec<u32>,
}

impl TileBuffer {
    /// An empty tile, with ids or without.
    pub(crate) fn new(with_ids: bool) -> Self {
        let n = STRIDE * (TILE + TINY_ROWS as usize);
        Self { depth: vec![1.0; n], ids: vec![NO_TRIANGLE; if with_ids { n } else { 0 }] }
    }
}

/// A tile's place in the image: its rows, each a slice of the image's row.
#[derive(Debug)]
pub(crate) struct Tile<'a> {
    depth: Vec<&'a mut [f32]>,
    ids: Vec<&'a mut [u32]>,
    /// Whether the rows hold something; else they are yet to be cleared.
    filled: bool,
}

impl Tile<'_> {
    /// Copies the tile, or what a clear tile holds, to the buffer.
    pub(crate) fn load(&self, buffer: &mut TileBuffer) {
        if !self.filled {
            buffer.depth.fill(1.0);
            return buffer.ids.fill(NO_TRIANGLE);
        }
        load_rows(&self.depth, &mut buffer.depth);
        load_rows(&self.ids, &mut buffer.ids);
    }

    /// Copies the buffer back.
    pub(crate) fn store(&mut self, buffer: &TileBuffer) {
        self.filled = true;
        store_rows(&mut self.depth, &buffer.depth);
        store_rows(&mut self.ids, &buffer.ids);
    }

    /// Clears the tile if nothing was drawn into it.
    pub(crate) fn finish(&mut self) {
        if !self.filled {
            self.depth.iter_mut().for_each(|row| row.fill(1.0));
            self.ids.iter_mut().for_each(|row| row.fill(NO_TRIANGLE));
        }
    }
}

fn load_rows<T: Copy>(rows: &[&mut [T]], buffer: &mut [T]) {
    for (row, to) in rows.iter().zip(buffer.chunks_exact_mut(STRIDE)) {
        to[..row.len()].copy_from_slice(row);
    }
}

fn store_rows<T: Copy>(rows: &mut [&mut [T]], buffer: &[T]) {
    for (row, from) in rows.iter_mut().zip(buffer.chunks_exact(STRIDE)) {
        row.copy_from_slice(&from[..row.len()]);
    }
}

/// An image to draw into.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    /// Pixels a row.
    pub(crate) width: usize,
    /// Depth, rows from the top.
    pub(crate) depth: &'a mut [f32],
    /// Triangle ids likewise; empty where nobody asks for them.
    pub(crate) ids: &'a mut [u32],
    /// Whether to start from a clear image.
    pub(crate) clear: bool,
}

impl<'a> Target<'a> {
    /// The image's tiles, row after row.
    pub(crate) fn into_tiles(self) -> Vec<Tile<'a>> {
        let (width, filled) = (self.width, !self.clear);
        let mut ids = split(self.ids, width).into_iter();
        let depth = split(self.depth, width).into_iter();
        depth.map(|depth| Tile { depth, ids: ids.next().unwrap_or_default(), filled }).collect()
    }
}

/// The rows of each tile of an image.
fn split<T>(image: &mut [T], width: usize) -> Vec<Vec<&mut [T]>> {
    let mut tiles = Vec::new();
    for band in image.chunks_mut(TILE * width) {
        let first = tiles.len();
        let height = band.len() / width;
        tiles.extend((0..width.div_ceil(TILE)).map(|_| Vec::with_capacity(height)));
        for row in band.chunks_mut(width) {
            for (tile, part) in tiles[first..].iter_mut().zip(row.chunks_mut(TILE)) {
                tile.push(part);
            }
        }
    }
    tiles
}
