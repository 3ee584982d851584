//! All lists of a light, as the tables that both halves of the kernel read.

use super::{
    light_frame::LightFrame,
    tile::{Scratch, TileLists, Weights},
    touches::TouchesByTile,
};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use umbrage_core::{
    Geometry, Light,
    glam::{UVec2, Vec3},
};

/// Rows of four words.
pub(super) type Rows = Arc<[[u32; 4]]>;

/// What making and asking cost, nanoseconds on two threads of a Xeon at 2.5 GHz; a million receivers.
const ITEM_NANOSECONDS: f32 = 12.0;
const CELL_NANOSECONDS: f32 = 8.0;
const TEST_NANOSECONDS: f32 = 3.0;
const RECEIVERS: f32 = 1e6;

/// The share of a face's tiles on which receivers lie, about.
const SEEN_TILES: f32 = 0.5;

/// Lights whose lists a geometry keeps: those that were asked for last.
const KEPT_LIGHTS: usize = 4;

/// Four tiles, or two items, are a row.
const TILES_A_ROW: usize = 2;
const ITEMS_A_ROW: usize = 2;

/// The lists of one light.
#[derive(Clone, Debug)]
pub(super) struct Lists {
    pub(super) frame: LightFrame,
    /// Two tiles a row: the first cell, and the cells along a side as a power of two.
    pub(super) tiles: Rows,
    /// A row a cell: first item, count, what is deeper than this is in shadow (bits of a float).
    pub(super) cells: Rows,
    /// Two items a row: caster, least depth (bits of a float).
    pub(super) items: Rows,
    /// Three rows a caster: its outline.
    pub(super) outlines: Rows,
    /// Three rows a caster: its corners.
    pub(super) corners: Rows,
}

/// The casters' corners, three rows a caster.
struct CornerRows(Rows);

impl CornerRows {
    fn of(geometry: &Geometry) -> Rows {
        let made = geometry.derived(|geometry| {
            let mut rows = zeros(3 * geometry.casters().len().max(1));
            let out = writable(&mut rows);
            let ids = geometry.casters().into_par_iter();
            out.par_chunks_exact_mut(3).zip(ids).for_each(|(out, id)| {
                for (row, corner) in out.iter_mut().zip(geometry.corners(id)) {
                    *row = corner.extend(0.0).to_array().map(f32::to_bits);
                }
            });
            Self(rows)
        });
        made.0.clone()
    }
}

/// The lists of the lights that were asked for last, kept with the triangles.
#[derive(Default)]
struct Kept(Mutex<Vec<Arc<Lists>>>);

impl Lists {
    /// Returns the lists of a light over a geometry's casters: made, or, if they were made lately, the same.
    pub(super) fn of(light: &Light, geometry: &Geometry) -> Arc<Self> {
        let frame = LightFrame::new(light, geometry);
        let kept = geometry.derived(|_| Kept::default());
        // The lists follow from the frame and the triangles alone.
        let is_same = |lists: &Arc<Self>| lists.frame == frame;
        let lock = || kept.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().iter().find(|lists| is_same(lists)) {
            return known.clone();
        }
        let made = Arc::new(Self::make(frame, geometry));
        let mut all = lock();
        if !all.iter().any(is_same) {
            if all.len() == KEPT_LIGHTS {
                all.remove(0);
            }
            all.push(made.clone());
        }
        made
    }

    fn make(frame: LightFrame, geometry: &Geometry) -> Self {
        let t0 = std::time::Instant::now();
        let casters = geometry.casters();
        let mut outlines = zeros(3 * casters.len().max(1));
        let chunk = casters.len().div_ceil(2 * rayon::current_num_threads()).max(1);
        let places: Vec<Vec3> = geometry
            .positions()
            .par_iter()
            .map(|&p| frame.place(p))
            .collect();
        let t1 = t0.elapsed();
        let corners_of = |id: u32| geometry.triangles()[id as usize].map(|v| places[v as usize]);
        let touches: Vec<TouchesByTile> = writable(&mut outlines)
            .par_chunks_mut(3 * chunk)
            .enumerate()
            .map(|(i, rows)| {
                let first = (i * chunk) as u32;
                let count = (rows.len() / 3).min(casters.len()) as u32;
                let corners = (0..count).map(|k| corners_of(casters.start + first + k));
                TouchesByTile::find(&frame, first, corners, rows)
            })
            .collect();
        drop(places);
        let t2 = t0.elapsed();
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
                line_of_tiles(&frame, line, &touches, &outlines, &weights, scratch)
            })
            .collect();
        drop(touches);
        let t3 = t0.elapsed();
        let [tiles, cells, items] = joined(&lists);
        let t4 = t0.elapsed();
        if std::env::var_os("SPENT").is_some() { eprintln!("SPENT place {:.1} touch {:.1} lists {:.1} join {:.1}; {} cells {} items", t1.as_secs_f64()*1e3, (t2-t1).as_secs_f64()*1e3, (t3-t2).as_secs_f64()*1e3, (t4-t3).as_secs_f64()*1e3, cells.len(), 2*items.len()); }
        Self {
            frame,
            tiles,
            cells,
            items,
            outlines,
            corners: CornerRows::of(geometry),
        }
    }
}

/// Makes the lists of a line of tiles across a face; lines are counted through all faces.
fn line_of_tiles(
    frame: &LightFrame,
    line: u32,
    touches: &[TouchesByTile],
    outlines: &[[u32; 4]],
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
            scratch.add(UVec2::new(x, y), part.of_tile(tile));
        }
        scratch.finish(frame, outlines, [face, x, y], weights, &mut out);
    }
    out
}

/// Returns the tables of all tiles, cells and items.
fn joined(lists: &[TileLists]) -> [Rows; 3] {
    let mut tiles = Vec::new();
    // Where the cells and the rows of items of each part begin.
    let mut starts = Vec::new();
    let [mut cell_count, mut item_rows] = [0, 0];
    for part in lists {
        starts.push([cell_count, item_rows]);
        for tile in &part.tiles {
            tiles.push([tile.first_cell + cell_count as u32, tile.side_log2]);
        }
        cell_count += part.cells.len();
        item_rows += part.items.len().div_ceil(ITEMS_A_ROW);
    }
    let tile_rows = tiles.chunks(TILES_A_ROW).map(|pair| {
        let last = pair[pair.len() - 1];
        [pair[0][0], pair[0][1], last[0], last[1]]
    });
    let tiles: Rows = tile_rows.collect();
    let mut cells = zeros(cell_count.max(1));
    let mut items = zeros(item_rows.max(1));
    let mut jobs = Vec::new();
    let mut cells_left = writable(&mut cells);
    let mut items_left = writable(&mut items);
    for (part, start) in lists.iter().zip(&starts) {
        let (part_cells, rest) = cells_left.split_at_mut(part.cells.len());
        cells_left = rest;
        let rows = part.items.len().div_ceil(ITEMS_A_ROW);
        let (part_items, rest) = items_left.split_at_mut(rows);
        items_left = rest;
        let first_item = (start[1] * ITEMS_A_ROW) as u32;
        jobs.push((part, first_item, part_cells, part_items));
    }
    jobs.into_par_iter().for_each(|(part, first_item, cells, items)| {
        for (out, cell) in cells.iter_mut().zip(&part.cells) {
            let covered_behind = cell.covered_behind.to_bits();
            *out = [first_item + cell.first, cell.count, covered_behind, 0];
        }
        for (out, pair) in items.iter_mut().zip(part.items.chunks(ITEMS_A_ROW)) {
            let last = pair[pair.len() - 1];
            *out = [
                pair[0].caster,
                pair[0].nearest.to_bits(),
                last.caster,
                last.nearest.to_bits(),
            ];
        }
    });
    [tiles, cells, items]
}

/// Returns rows of zeros, to be written once.
fn zeros(count: usize) -> Rows {
    std::iter::repeat_n([0; 4], count).collect()
}

/// Returns the rows of a table that nobody else has yet.
fn writable(rows: &mut Rows) -> &mut [[u32; 4]] {
    Arc::get_mut(rows).expect("made here, and not shared yet")
}
