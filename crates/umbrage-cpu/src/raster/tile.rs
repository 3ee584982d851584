//! Tiles: parts of the image that one thread fills at a time, in a small buffer that stays in the
//! nearest cache.

use crate::raster::{bin::TILE, mode::Mode};
use umbrage_core::NO_TRIANGLE;

/// Pixels filled at once.
pub(crate) const LANES: usize = 8;
/// Rows of the smallest triangles.
pub(crate) const TINY_ROWS: i32 = 4;
/// Floats between rows of a tile's buffer. Lanes may exceed a row's right end, into floats that are
/// never copied back.
pub(crate) const STRIDE: usize = TILE + LANES;

/// Buffer of the tile that is being filled.
#[derive(Debug)]
pub(crate) struct TileBuffer {
    /// Depths or counts. Spare rows at the end receive pixels below the tile, and ensure that a
    /// whole stride follows every row.
    pub(crate) texels: Vec<f32>,
    /// Triangle ids, if the mode has them.
    pub(crate) ids: Vec<u32>,
    /// Depths of another image, if the mode reads them.
    pub(crate) other: Vec<f32>,
}

impl TileBuffer {
    /// Returns an empty tile for a mode.
    pub(crate) fn new(mode: Mode) -> Self {
        let n = STRIDE * (TILE + TINY_ROWS as usize);
        Self {
            texels: vec![mode.clear_value(); n],
            ids: vec![NO_TRIANGLE; if mode.has_ids() { n } else { 0 }],
            other: vec![1.0; if mode.reads_other_image() { n } else { 0 }],
        }
    }
}

/// Tile in the image: its rows, each a slice of the image's row.
#[derive(Debug)]
pub(crate) struct Tile<'a> {
    texels: Vec<&'a mut [f32]>,
    ids: Vec<&'a mut [u32]>,
    other: Vec<&'a [f32]>,
    /// Value of a clear tile.
    clear_value: f32,
    /// True if the rows have content; otherwise they must still be cleared.
    filled: bool,
}

impl Tile<'_> {
    /// Copies the tile, or the value of a clear tile, to the buffer.
    pub(crate) fn load(&self, buffer: &mut TileBuffer) {
        load_rows(self.other.iter().copied(), &mut buffer.other);
        if !self.filled {
            buffer.texels.fill(self.clear_value);
            return buffer.ids.fill(NO_TRIANGLE);
        }
        load_rows(self.texels.iter().map(|row| &**row), &mut buffer.texels);
        load_rows(self.ids.iter().map(|row| &**row), &mut buffer.ids);
    }

    /// Copies the buffer back.
    pub(crate) fn store(&mut self, buffer: &TileBuffer) {
        self.filled = true;
        store_rows(&mut self.texels, &buffer.texels);
        store_rows(&mut self.ids, &buffer.ids);
    }

    /// Clears the tile if nothing was drawn into it.
    pub(crate) fn finish(&mut self) {
        if !self.filled {
            self.texels
                .iter_mut()
                .for_each(|row| row.fill(self.clear_value));
            self.ids.iter_mut().for_each(|row| row.fill(NO_TRIANGLE));
        }
    }
}

fn load_rows<'a, T: Copy + 'a>(rows: impl Iterator<Item = &'a [T]>, buffer: &mut [T]) {
    for (row, to) in rows.zip(buffer.chunks_exact_mut(STRIDE)) {
        to[..row.len()].copy_from_slice(row);
    }
}

fn store_rows<T: Copy>(rows: &mut [&mut [T]], buffer: &[T]) {
    for (row, from) in rows.iter_mut().zip(buffer.chunks_exact(STRIDE)) {
        row.copy_from_slice(&from[..row.len()]);
    }
}

/// Image to draw into.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    /// Pixels per row.
    pub(crate) width: usize,
    /// Depths or counts, rows from the top.
    pub(crate) texels: &'a mut [f32],
    /// Triangle ids, rows from the top, for [`Mode::DepthWithIds`]; otherwise empty.
    pub(crate) ids: &'a mut [u32],
    /// Image that [`Mode::DepthPeel`] and [`Mode::StencilDepthFail`] read, rows from the top;
    /// otherwise empty.
    pub(crate) other: &'a [f32],
    /// True if drawing starts from a clear image.
    pub(crate) clear: bool,
}

impl<'a> Target<'a> {
    /// Returns the image's tiles, row after row.
    pub(crate) fn into_tiles(self, mode: Mode) -> Vec<Tile<'a>> {
        let (width, clear_value, filled) = (self.width, mode.clear_value(), !self.clear);
        let columns = width.div_ceil(TILE);
        let texels = split(
            self.texels
                .chunks_mut(width)
                .map(|row| row.chunks_mut(TILE)),
            columns,
        );
        let mut ids = split(
            self.ids.chunks_mut(width).map(|row| row.chunks_mut(TILE)),
            columns,
        )
        .into_iter();
        let mut other = split(
            self.other.chunks(width).map(|row| row.chunks(TILE)),
            columns,
        )
        .into_iter();
        let tile = |texels| {
            let (ids, other) = (
                ids.next().unwrap_or_default(),
                other.next().unwrap_or_default(),
            );
            Tile {
                texels,
                ids,
                other,
                clear_value,
                filled,
            }
        };
        texels.into_iter().map(tile).collect()
    }
}

/// Returns the rows of each tile of an image, from the parts of each of its rows.
fn split<T>(rows: impl Iterator<Item = impl Iterator<Item = T>>, columns: usize) -> Vec<Vec<T>> {
    let mut tiles = Vec::new();
    for (y, parts) in rows.enumerate() {
        if y % TILE == 0 {
            tiles.extend((0..columns).map(|_| Vec::with_capacity(TILE)));
        }
        let first = tiles.len() - columns;
        tiles[first..]
            .iter_mut()
            .zip(parts)
            .for_each(|(tile, part)| tile.push(part));
    }
    tiles
}
