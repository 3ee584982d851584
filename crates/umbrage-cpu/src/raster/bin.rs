//! Assignment of triangles to tiles.

use crate::raster::record::Record;
use glam::UVec2;

/// Pixels on a tile's side.
pub(crate) const TILE: usize = 64;

/// Triangles fetched at a time.
pub(crate) const FETCH: usize = 16;

/// Triangles of one chunk of input, sorted by tile. Buffers are kept between uses.
#[derive(Debug, Default)]
pub(crate) struct Bins {
    /// All triangles of the chunk that may cover a pixel.
    records: Vec<Record>,
    /// Tiles that each of them may touch.
    touched: Vec<Touched>,
    /// Tiles in a row of the image.
    columns: usize,
    /// Before sorting, the number of records that touch each tile. After it, the start of each tile
    /// in `order`, and the end.
    starts: Vec<u32>,
    /// Indices into `records`.
    order: Vec<u32>,
}

/// Rectangle of tiles. The largest image has 256 of them on a side.
#[derive(Clone, Copy, Debug, Default)]
struct Touched {
    min: [u8; 2],
    max: [u8; 2],
}

impl Touched {
    #[inline(always)]
    fn of_record(r: &Record) -> Self {
        let tile = |pixel: u16| (pixel / TILE as u16) as u8;
        Self {
            min: [tile(r.min[0]), tile(r.min[1])],
            max: [tile(r.max[0]), tile(r.max[1])],
        }
    }

    /// Calls `f` with the index of each of its tiles, row by row in the image.
    #[inline(always)]
    fn for_each(self, columns: usize, mut f: impl FnMut(usize)) {
        let first = usize::from(self.min[1]) * columns + usize::from(self.min[0]);
        if self.min == self.max {
            return f(first);
        }
        for down in 0..=usize::from(self.max[1] - self.min[1]) {
            for right in 0..=usize::from(self.max[0] - self.min[0]) {
                f(first + down * columns + right);
            }
        }
    }
}

impl Bins {
    /// Removes all triangles, and sets the number of tiles.
    pub(crate) fn clear(&mut self, size: UVec2) {
        self.columns = size.x.div_ceil(TILE as u32) as usize;
        let tiles = self.columns * size.y.div_ceil(TILE as u32) as usize;
        self.records.clear();
        self.touched.clear();
        self.starts.clear();
        self.starts.resize(tiles + 1, 0);
    }

    /// Adds a triangle.
    #[inline(always)]
    pub(crate) fn push(&mut self, record: Record) {
        let touched = Touched::of_record(&record);
        touched.for_each(self.columns, |tile| self.starts[tile] += 1);
        self.touched.push(touched);
        self.records.push(record);
    }

    /// Sorts the triangles by tile (counting sort).
    #[inline(always)]
    pub(crate) fn sort(&mut self) {
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.order.clear();
        self.order.resize(sum as usize, 0);
        // Counts are now ends. Filling from the back converts them to starts, and keeps the order
        // of the records.
        for (i, touched) in self.touched.iter().enumerate().rev() {
            touched.for_each(self.columns, |tile| {
                let end = &mut self.starts[tile];
                *end -= 1;
                self.order[*end as usize] = i as u32;
            });
        }
    }

    /// Returns the number of triangles that touch a tile.
    pub(crate) fn count(&self, tile: usize) -> u32 {
        self.starts[tile + 1] - self.starts[tile]
    }

    /// Returns the indices of the triangles that touch a tile, in order.
    pub(crate) fn of_tile(&self, tile: usize) -> &[u32] {
        &self.order[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }

    /// Copies the triangles with these indices (at most `FETCH`). They are far apart in memory,
    /// outside the nearest caches, so fetching several takes little longer than fetching one.
    #[inline(always)]
    pub(crate) fn fetch<'a>(
        &self,
        numbers: &[u32],
        fetched: &'a mut [Record; FETCH],
    ) -> &'a [Record] {
        for (record, &i) in fetched.iter_mut().zip(numbers) {
            *record = self.records[i as usize];
        }
        &fetched[..numbers.len()]
    }

    /// Returns the bytes of its buffers.
    pub(crate) fn bytes(&self) -> usize {
        let words = self.starts.capacity() + self.order.capacity() + self.touched.capacity();
        self.records.capacity() * size_of::<Record>() + 4 * words
    }
}
