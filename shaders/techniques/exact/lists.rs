//! All lists of a light, as tables that both halves of the kernel read.

use super::{
    light_frame::LightFrame,
    tile::{Scratch, TileLists, TilePlace, Weights},
    touches::TouchesByTile,
};
use std::sync::{
    Arc, Mutex, OnceLock, PoisonError,
    atomic::{AtomicU32, Ordering},
};
use umbrage_core::parallel::prelude::*;
use umbrage_core::{Geometry, Light};

/// Rows of four words.
pub(super) type Rows = Arc<[[u32; 4]]>;

/// Approximate build and query costs on two threads of a Xeon, nanoseconds. Of six candidates,
/// these values gave the least total time.
const ITEM_NANOSECONDS: f32 = 12.0;
const CELL_NANOSECONDS: f32 = 8.0;
const TEST_NANOSECONDS: f32 = 2.0;
/// Approximate number of receivers of an image.
const RECEIVERS: f32 = 1e6;

/// Approximate fraction of a face's tiles that contain receivers.
const SEEN_TILES: f32 = 0.5;

/// Number of lights whose lists a geometry caches, latest first.
const KEPT_LIGHTS: usize = 4;

/// Number of images of the same casters under the same light that are computed before lists are
/// built.
const PICTURES_WITHOUT: u32 = 8;
/// Least number of casters for which images are computed without lists. With fewer casters, lists
/// take about the same time or less: `docs/measured.md` has the measured frames.
const CASTERS_WITHOUT: usize = 60_000;

/// Number of tiles per row.
const TILES_A_ROW: usize = 2;

/// Number of items per row.
const ITEMS_A_ROW: usize = 2;

/// Lists of one light.
#[derive(Clone, Debug)]
pub(super) struct Lists {
    pub(super) frame: LightFrame,
    /// Two tiles per row: the first cell, and the number of cells along a side as a power of two.
    pub(super) tiles: Rows,
    /// One row per cell, and one at the end: first item, depth beyond which everything is in
    /// shadow, first depth of the steps, and one over the width of a step (bits of floats).
    pub(super) cells: Rows,
    /// Two items per row: the caster, and its box and depth in one word.
    pub(super) items: Rows,
    /// Three rows per caster: its corners. The fourth word of the second is the row of its record
    /// in the alpha test table, or 0 if the caster is opaque.
    pub(super) corners: Rows,
}

/// Corners of the casters, three rows per caster, computed on first use.
#[derive(Default)]
pub(super) struct CornerRows(OnceLock<Rows>);

impl CornerRows {
    pub(super) fn of_geometry(geometry: &Geometry) -> Rows {
        let kept = geometry.derive_once(|_| Self::default());
        let make = || {
            let mut rows = zeros(3 * geometry.casters().len().max(1));
            let out = writable(&mut rows);
            let ids = geometry.casters().into_par_iter();
            out.par_chunks_exact_mut(3).zip(ids).for_each(|(out, id)| {
                for (row, corner) in out.iter_mut().zip(geometry.corners(id)) {
                    *row = corner.extend(0.0).to_array().map(f32::to_bits);
                }
                let cut_outs = geometry.cut_outs();
                out[1][3] = cut_outs.and_then(|c| c.record_row(id)).unwrap_or(0);
            });
            rows
        };
        if let Some(rows) = kept.0.get() {
            return rows.clone();
        }
        // Compute without a lock, as described at `TableRows`.
        let rows = make();
        kept.0.get_or_init(|| rows).clone()
    }
}

/// Cached lists of the latest lights, stored with the triangles.
#[derive(Default)]
struct Kept(Mutex<Vec<Arc<KeptLists>>>);

/// Lists of one light, built when they are first read.
#[derive(Debug)]
pub(super) struct KeptLists {
    pub(super) frame: LightFrame,
    made: OnceLock<Lists>,
    /// Number of images that were computed without the lists.
    answered_without: AtomicU32,
}

impl KeptLists {
    /// Returns the lists of a light over a geometry's casters, from the cache if possible.
    pub(super) fn of_light(light: &Light, geometry: &Geometry) -> Arc<Self> {
        let frame = LightFrame::new(light, geometry);
        // Create the slot for corners early: copies of the geometry share only what was created
        // before.
        geometry.derive_once(|_| CornerRows::default());
        let kept = geometry.derive_once(|_| Kept::default());
        // The lists follow from the frame and the triangles.
        let is_same = |lists: &Arc<Self>| lists.frame == frame;
        let lock = || kept.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().iter().find(|lists| is_same(lists)) {
            return known.clone();
        }
        let new = Arc::new(Self {
            frame,
            made: OnceLock::new(),
            answered_without: AtomicU32::new(0),
        });
        let mut all = lock();
        if all.len() == KEPT_LIGHTS {
            all.remove(0);
        }
        all.push(new.clone());
        new
    }

    /// Returns the lists, which are built on first use. `geometry` is that of
    /// [`of_light`](Self::of_light).
    pub(super) fn get(&self, geometry: &Geometry) -> &Lists {
        if let Some(lists) = self.made.get() {
            return lists;
        }
        // Build without a lock, as described at `TableRows`.
        let lists = Lists::make(self.frame, geometry);
        self.made.get_or_init(|| lists)
    }

    /// Counts another image of this number of casters that have not moved. Returns whether to
    /// compute it without lists: building lists costs as much as several images without them.
    pub(super) fn is_answered_without(&self, casters: usize) -> bool {
        casters >= CASTERS_WITHOUT
            && self.made.get().is_none()
            && self.answered_without.fetch_add(1, Ordering::Relaxed) < PICTURES_WITHOUT
    }
}

impl Lists {
    /// Returns how many triangles were placed on the grid and in lists, counting repetitions.
    pub(super) fn triangles_listed(&self) -> u64 {
        let items = self.items.len() * ITEMS_A_ROW;
        (items + self.casters()) as u64
    }

    /// Returns the number of casters.
    pub(super) fn casters(&self) -> usize {
        self.corners.len() / 3
    }

    fn make(frame: LightFrame, geometry: &Geometry) -> Self {
        // Find the touches of all casters, in parallel chunks.
        let casters = geometry.casters();
        let chunk = casters
            .len()
            .div_ceil(2 * umbrage_core::parallel::current_num_threads())
            .max(1) as u32;
        let firsts: Vec<u32> = casters.clone().step_by(chunk as usize).collect();
        let touches: Vec<TouchesByTile> = firsts
            .into_par_iter()
            .map(|first| {
                let end = casters.end.min(first + chunk);
                TouchesByTile::find(&frame, geometry, first..end)
            })
            .collect();
        // Build the lists of each row of tiles.
        let weights = Weights {
            item: ITEM_NANOSECONDS,
            cell: CELL_NANOSECONDS,
            test: TEST_NANOSECONDS,
            receivers: RECEIVERS / (SEEN_TILES * frame.tile_count() as f32),
        };
        let lines = frame.faces() * frame.tiles.y;
        let lists: Vec<TileLists> = (0..lines)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, line| {
                line_of_tiles(&frame, geometry, line, &touches, &weights, scratch)
            })
            .collect();
        drop(touches);

        let [tiles, cells, items] = join_lists(&lists);
        Self {
            frame,
            tiles,
            cells,
            items,
            corners: CornerRows::of_geometry(geometry),
        }
    }
}

/// Builds the lists of a row of tiles across a face; rows are counted through all faces.
fn line_of_tiles(
    frame: &LightFrame,
    geometry: &Geometry,
    line: u32,
    touches: &[TouchesByTile],
    weights: &Weights,
    scratch: &mut Scratch,
) -> TileLists {
    let mut out = TileLists::default();
    let face = line / frame.tiles.y;
    let y = line % frame.tiles.y;
    for x in 0..frame.tiles.x {
        let tile = (line * frame.tiles.x + x) as usize;
        scratch.clear();
        for part in touches {
            scratch.add(part.of_tile(tile));
        }
        let place = TilePlace { face, x, y };
        scratch.finish(frame, geometry, place, weights, &mut out);
    }
    out
}

/// Returns the joined tables of all tiles, cells and items.
fn join_lists(lists: &[TileLists]) -> [Rows; 3] {
    let mut tiles = Vec::new();
    let mut starts = Vec::new();
    let mut end = PartStart::default();
    // Compute where each part starts.
    for part in lists {
        starts.push(end);
        for tile in &part.tiles {
            tiles.push([tile.first_cell + end.cell as u32, tile.side_log2]);
        }
        end.cell += part.cells.len();
        // Each part begins a row.
        end.item_row += part.items.len().div_ceil(ITEMS_A_ROW);
    }
    // Store two tiles per row.
    let tile_rows = tiles.chunks(TILES_A_ROW).map(|pair| {
        let last = pair[pair.len() - 1];
        [pair[0][0], pair[0][1], last[0], last[1]]
    });
    let tiles: Rows = tile_rows.collect();
    let mut cells = zeros(end.cell + 1);
    let mut items = zeros(end.item_row.max(1));
    // Copy the parts in parallel.
    let mut jobs = Vec::new();
    let mut cells_left = writable(&mut cells);
    let mut items_left = writable(&mut items);
    for (part, start) in lists.iter().zip(starts) {
        let item_rows = part.items.len().div_ceil(ITEMS_A_ROW);
        jobs.push(PartCopy {
            part,
            start,
            cells: split_front(&mut cells_left, part.cells.len()),
            items: split_front(&mut items_left, item_rows),
        });
    }
    // Write the end of the last list.
    cells_left[0][0] = (end.item_row * ITEMS_A_ROW) as u32;
    jobs.into_par_iter().for_each(PartCopy::run);
    [tiles, cells, items]
}

/// Start of a part in the joined tables.
#[derive(Clone, Copy, Default)]
struct PartStart {
    cell: usize,
    item_row: usize,
}

/// Copy of a part into its rows of the joined tables.
struct PartCopy<'a> {
    part: &'a TileLists,
    start: PartStart,
    cells: &'a mut [[u32; 4]],
    items: &'a mut [[u32; 4]],
}

impl PartCopy<'_> {
    fn run(self) {
        let first_item = (self.start.item_row * ITEMS_A_ROW) as u32;
        for (out, cell) in self.cells.iter_mut().zip(&self.part.cells) {
            let floats = [cell.covered_behind, cell.depth_base, cell.steps_a_depth];
            let [covered_behind, depth_base, steps_a_depth] = floats.map(f32::to_bits);
            *out = [
                first_item + cell.first,
                covered_behind,
                depth_base,
                steps_a_depth,
            ];
        }
        for (out, pair) in self
            .items
            .iter_mut()
            .zip(self.part.items.chunks(ITEMS_A_ROW))
        {
            // A part with an odd number of items repeats its last one.
            let last = pair[pair.len() - 1];
            *out = [pair[0][0], pair[0][1], last[0], last[1]];
        }
    }
}

/// Splits off the first `count` rows.
fn split_front<'a>(rows: &mut &'a mut [[u32; 4]], count: usize) -> &'a mut [[u32; 4]] {
    let (front, rest) = std::mem::take(rows).split_at_mut(count);
    *rows = rest;
    front
}

/// Returns rows of zeros, to be overwritten once.
fn zeros(count: usize) -> Rows {
    std::iter::repeat_n([0; 4], count).collect()
}

/// Returns the mutable rows of a table that is not shared yet.
fn writable(rows: &mut Rows) -> &mut [[u32; 4]] {
    Arc::get_mut(rows).expect("created here and not shared yet")
}
