//! All lists of a light, as the tables that both halves of the kernel read.

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

/// What making and asking cost on two threads of a Xeon, nanoseconds, about: of six choices that
/// were tried, these gave the least time of both together.
const ITEM_NANOSECONDS: f32 = 12.0;
const CELL_NANOSECONDS: f32 = 8.0;
const TEST_NANOSECONDS: f32 = 2.0;
/// Receivers of a picture, about.
const RECEIVERS: f32 = 1e6;

/// The share of a face's tiles on which receivers lie, about.
const SEEN_TILES: f32 = 0.5;

/// Lights whose lists a geometry keeps: those that were asked for last.
const KEPT_LIGHTS: usize = 4;

/// Pictures of the same casters under the same light that are answered before their lists are made.
const PICTURES_WITHOUT: u32 = 8;
/// Fewer casters are listed and looked up about as soon as they ask receivers, or sooner:
/// `docs/measured.md` has the frames that were timed.
const CASTERS_WITHOUT: usize = 60_000;

/// Tiles of a row.
const TILES_A_ROW: usize = 2;

/// Items of a row.
const ITEMS_A_ROW: usize = 2;

/// The lists of one light.
#[derive(Clone, Debug)]
pub(super) struct Lists {
    pub(super) frame: LightFrame,
    /// Two tiles a row: the first cell, and the cells along a side as a power of two.
    pub(super) tiles: Rows,
    /// A row a cell, and one at the end: first item, what is deeper than this is in shadow, where
    /// steps of depth begin, and one over their width (bits of floats).
    pub(super) cells: Rows,
    /// Two items a row: caster, and its box and depth in one word.
    pub(super) items: Rows,
    /// Three rows a caster: its corners. The fourth word of the second is the row of its record
    /// among the cut-outs, 0 if it has no holes.
    pub(super) corners: Rows,
}

/// The casters' corners, three rows a caster, once they were asked for.
#[derive(Default)]
struct CornerRows(OnceLock<Rows>);

impl CornerRows {
    fn of(geometry: &Geometry) -> Rows {
        let kept = geometry.derived(|_| Self::default());
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
        // Without a lock, as `TableRows` says.
        let rows = make();
        kept.0.get_or_init(|| rows).clone()
    }
}

/// The lists of the lights that were asked for last, kept with the triangles.
#[derive(Default)]
struct Kept(Mutex<Vec<Arc<KeptLists>>>);

/// The lists of one light, made when somebody reads them.
#[derive(Debug)]
pub(super) struct KeptLists {
    pub(super) frame: LightFrame,
    made: OnceLock<Lists>,
    /// Pictures that were answered without them.
    answered_without: AtomicU32,
}

impl KeptLists {
    /// Returns the lists of a light over a geometry's casters: if they were asked for lately, the
    /// same.
    pub(super) fn of(light: &Light, geometry: &Geometry) -> Arc<Self> {
        let frame = LightFrame::new(light, geometry);
        // Copies of the geometry share what was made before they were, so the place for corners is.
        geometry.derived(|_| CornerRows::default());
        let kept = geometry.derived(|_| Kept::default());
        // The lists follow from the frame and the triangles alone.
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

    /// Returns the lists of no casters: for what knows them elsewhere.
    pub(super) fn without_casters(frame: LightFrame) -> Self {
        Self {
            frame,
            made: OnceLock::from(Lists::without_casters(frame)),
            answered_without: AtomicU32::new(0),
        }
    }

    /// Returns the lists; they are made now if nobody asked before. `geometry` is that of
    /// [`of`](Self::of), or none if it was not called.
    pub(super) fn get(&self, geometry: &Geometry) -> &Lists {
        if let Some(lists) = self.made.get() {
            return lists;
        }
        // Without a lock, as `TableRows` says.
        let lists = Lists::make(self.frame, geometry);
        self.made.get_or_init(|| lists)
    }

    /// Counts one more picture of so many casters that have not moved. Returns whether it is to be
    /// answered without lists: they take as long to make as some pictures without them, and only
    /// then are the quicker way.
    pub(super) fn is_answered_without(&self, casters: usize) -> bool {
        casters >= CASTERS_WITHOUT
            && self.made.get().is_none()
            && self.answered_without.fetch_add(1, Ordering::Relaxed) < PICTURES_WITHOUT
    }
}

impl Lists {
    /// Returns the lists of no casters.
    fn without_casters(frame: LightFrame) -> Self {
        let tile_rows = frame.tile_count().div_ceil(TILES_A_ROW);
        let nothing_covers = [0, f32::INFINITY.to_bits(), f32::INFINITY.to_bits(), 0];
        Self {
            frame,
            tiles: zeros(tile_rows),
            cells: Arc::new([nothing_covers; 2]),
            items: zeros(1),
            corners: zeros(3),
        }
    }

    /// Returns how many triangles were placed on the grid and in lists, each as often as it was.
    pub(super) fn triangles_listed(&self) -> u64 {
        let items = self.items.len() * ITEMS_A_ROW;
        (items + self.casters()) as u64
    }

    /// Returns the number of casters.
    pub(super) fn casters(&self) -> usize {
        self.corners.len() / 3
    }

    fn make(frame: LightFrame, geometry: &Geometry) -> Self {
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

        let [tiles, cells, items] = joined(&lists);
        Self {
            frame,
            tiles,
            cells,
            items,
            corners: CornerRows::of(geometry),
        }
    }
}

/// Makes the lists of a line of tiles across a face; lines are counted through all faces.
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

/// Returns the tables of all tiles, cells and items.
fn joined(lists: &[TileLists]) -> [Rows; 3] {
    let mut tiles = Vec::new();
    let mut starts = Vec::new();
    let mut end = PartStart::default();
    for part in lists {
        starts.push(end);
        for tile in &part.tiles {
            tiles.push([tile.first_cell + end.cell as u32, tile.side_log2]);
        }
        end.cell += part.cells.len();
        // Each part begins a row.
        end.item_row += part.items.len().div_ceil(ITEMS_A_ROW);
    }
    let tile_rows = tiles.chunks(TILES_A_ROW).map(|pair| {
        let last = pair[pair.len() - 1];
        [pair[0][0], pair[0][1], last[0], last[1]]
    });
    let tiles: Rows = tile_rows.collect();
    let mut cells = zeros(end.cell + 1);
    let mut items = zeros(end.item_row.max(1));
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
    // Where the last list ends.
    cells_left[0][0] = (end.item_row * ITEMS_A_ROW) as u32;
    jobs.into_par_iter().for_each(PartCopy::run);
    [tiles, cells, items]
}

/// Where a part begins in the tables of all.
#[derive(Clone, Copy, Default)]
struct PartStart {
    cell: usize,
    item_row: usize,
}

/// A part, and its rows of the tables of all.
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
            // A part with an odd number of items has its last one twice.
            let last = pair[pair.len() - 1];
            *out = [pair[0][0], pair[0][1], last[0], last[1]];
        }
    }
}

/// Takes the first `count` rows off.
fn split_front<'a>(rows: &mut &'a mut [[u32; 4]], count: usize) -> &'a mut [[u32; 4]] {
    let (front, rest) = std::mem::take(rows).split_at_mut(count);
    *rows = rest;
    front
}

/// Returns rows of zeros, to be written once.
fn zeros(count: usize) -> Rows {
    std::iter::repeat_n([0; 4], count).collect()
}

/// Returns the rows of a table that nobody else has yet.
fn writable(rows: &mut Rows) -> &mut [[u32; 4]] {
    Arc::get_mut(rows).expect("made here, and not shared yet")
}
