//! The lists of one tile's cells.

use super::{
    light_frame::LightFrame,
    outline::Outline,
    touches::{DEPTH_UNKNOWN, FINEST, Touch},
};
use umbrage_core::glam::{UVec2, Vec3, Vec4};

/// One triangle of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Item {
    /// As [`Touch::caster`].
    pub(super) caster: u32,
    /// Least depth that it has in the cell, less the margin.
    pub(super) nearest: f32,
}

/// A cell's list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Its first item.
    pub(super) first: u32,
    pub(super) count: u32,
    /// What is deeper is in shadow: the greatest depth, with the margin, of the nearest triangle that covers the whole cell.
    pub(super) covered_behind: f32,
}

/// Where a tile's cells are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tile {
    pub(super) first_cell: u32,
    /// Cells along a side, as a power of two.
    pub(super) side_log2: u32,
}

/// The lists of some tiles.
#[derive(Debug, Default)]
pub(super) struct TileLists {
    pub(super) tiles: Vec<Tile>,
    pub(super) cells: Vec<Cell>,
    pub(super) items: Vec<Item>,
}

/// What making lists and asking them costs, in nanoseconds or anything else: `bench` measures, and only proportions matter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// One item of a list, made once.
    pub(super) item: f32,
    /// One cell, made once.
    pub(super) cell: f32,
    /// One item, asked once.
    pub(super) test: f32,
    /// How many receivers ask in a tile.
    pub(super) receivers: f32,
}

/// Memory that is used for one tile after the other.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    touches: Vec<Touch>,
    /// Items and their cells, in the order in which they are found.
    found: Vec<(u32, Item)>,
    counts: Vec<u32>,
    covered: Vec<f32>,
    sorted: Vec<Item>,
}

impl Scratch {
    /// Begins a tile: forgets the last one's touches.
    pub(super) fn clear(&mut self) {
        self.touches.clear();
    }

    /// Adds touches of the tile, with their boxes cut to it.
    pub(super) fn add(&mut self, tile: UVec2, touches: &[Touch]) {
        let low = tile << FINEST;
        let high = low + (1 << FINEST) - 1;
        let cut = |at: [u16; 2]| {
            let at = UVec2::new(u32::from(at[0]), u32::from(at[1])).clamp(low, high) - low;
            [at.x as u16, at.y as u16]
        };
        self.touches.extend(touches.iter().map(|t| Touch {
            low: cut(t.low),
            high: cut(t.high),
            ..*t
        }));
    }

    /// Makes the tile's lists.
    pub(super) fn finish(
        &mut self,
        frame: &LightFrame,
        outlines: &[[u32; 4]],
        [face, x, y]: [u32; 3],
        weights: &Weights,
        out: &mut TileLists,
    ) {
        let side_log2 = best_side(&self.touches, weights);
        let tile = Tile {
            first_cell: out.cells.len() as u32,
            side_log2,
        };
        out.tiles.push(tile);
        let cells = 1_usize << (2 * side_log2);
        self.counts.clear();
        self.counts.resize(cells, 0);
        self.covered.clear();
        self.covered.resize(cells, f32::INFINITY);
        self.found.clear();
        let tile_side = 1.0 / frame.tiles_a_unit;
        let low = Vec3::new(
            x as f32 * tile_side - frame.half.x,
            y as f32 * tile_side - frame.half.y,
            1.0,
        );
        let step = tile_side / (1 << side_log2) as f32;
        let shift = FINEST - side_log2;
        for i in 0..self.touches.len() {
            let touch = self.touches[i];
            let [x0, y0] = touch.low.map(|v| u32::from(v) >> shift);
            let [x1, y1] = touch.high.map(|v| u32::from(v) >> shift);
            if x0 == x1 && y0 == y1 {
                self.push((y0 << side_log2) + x0, &touch, touch.nearest);
                continue;
            }
            let outline = Outline::of_caster(outlines, touch.caster & !DEPTH_UNKNOWN);
            let [across, down, summand] = outline.on_face(frame.is_lamp, face);
            let at_tile = summand + across * low.x + down * low.y;
            let [across, down] = [across * step, down * step];
            let up = across.max(Vec4::ZERO) + down.max(Vec4::ZERO);
            let to_least = across.min(Vec4::ZERO) + down.min(Vec4::ZERO);
            for cy in y0..=y1 {
                let at_row = at_tile + down * cy as f32;
                for cx in x0..=x1 {
                    let at_cell = at_row + across * cx as f32;
                    let greatest = at_cell + up;
                    // The fourth lane, depth, counts as inside.
                    if greatest.with_w(0.0).cmplt(Vec4::NEG_ONE).any() {
                        continue;
                    }
                    let cell = (cy << side_log2) + cx;
                    if touch.caster & DEPTH_UNKNOWN != 0 {
                        self.push(cell, &touch, touch.nearest);
                        continue;
                    }
                    let least = at_cell + to_least;
                    let nearest = frame.nearest_of_plane(greatest.w);
                    self.push(cell, &touch, nearest.max(touch.nearest));
                    if least.truncate().cmpgt(Vec3::ONE).all() {
                        let covered = &mut self.covered[cell as usize];
                        *covered = covered.min(frame.farthest_of_plane(least.w));
                    }
                }
            }
        }
        self.emit(out);
    }

    #[inline(always)]
    fn push(&mut self, cell: u32, touch: &Touch, nearest: f32) {
        let caster = touch.caster;
        self.found.push((cell, Item { caster, nearest }));
        self.counts[cell as usize] += 1;
    }

    /// Sorts what was found by cell and depth, and leaves out what lies behind the cell's cover.
    fn emit(&mut self, out: &mut TileLists) {
        let Self {
            found,
            counts,
            covered,
            sorted,
            ..
        } = self;
        // Where each cell's items go: the counts become ends, and by filling from the back beginnings.
        let mut end = 0;
        for count in counts.iter_mut() {
            end += *count;
            *count = end;
        }
        sorted.clear();
        sorted.resize(found.len(), Item::default());
        for &(cell, item) in found.iter() {
            let place = &mut counts[cell as usize];
            *place -= 1;
            sorted[*place as usize] = item;
        }
        for (i, &covered_behind) in covered.iter().enumerate() {
            let begin = counts[i] as usize;
            let end = counts.get(i + 1).map_or(sorted.len(), |&next| next as usize);
            let list = &mut sorted[begin..end];
            sort_by_depth(list);
            let first = out.items.len() as u32;
            let kept = list.iter().take_while(|item| item.nearest <= covered_behind);
            out.items.extend(kept);
            out.cells.push(Cell {
                first,
                count: out.items.len() as u32 - first,
                covered_behind,
            });
        }
    }
}

/// Sorts a list, mostly a short one, from near to far.
fn sort_by_depth(list: &mut [Item]) {
    const SHORT: usize = 24;
    if list.len() > SHORT {
        list.sort_unstable_by(|a, b| a.nearest.total_cmp(&b.nearest));
        return;
    }
    for i in 1..list.len() {
        let item = list[i];
        let mut place = i;
        while place > 0 && list[place - 1].nearest > item.nearest {
            list[place] = list[place - 1];
            place -= 1;
        }
        list[place] = item;
    }
}

/// Returns how finely a tile is best divided: the least of what its lists cost to make, which finer cells raise, and to ask, which
/// they lower.
fn best_side(touches: &[Touch], weights: &Weights) -> u32 {
    // A triangle of area A in a box of w x h cells touches A + w + h + 1 of them in the mean (the area of its sum with a cell).
    let tile_side = (1_u32 << FINEST) as f32;
    let mut widths = 0.0;
    let mut areas = 0.0;
    for touch in touches {
        let wide = f32::from(touch.high[0] - touch.low[0]) / tile_side;
        let high = f32::from(touch.high[1] - touch.low[1]) / tile_side;
        widths += wide + high;
        areas += 0.5 * wide * high;
    }
    let cost = |side_log2: u32| {
        let side = (1 << side_log2) as f32;
        let cells = side * side;
        let items = areas * cells + widths * side + touches.len() as f32;
        let made = weights.item * items + weights.cell * cells;
        let asked = weights.test * weights.receivers * items / cells;
        made + asked
    };
    let mut best = 0;
    for side_log2 in 1..=FINEST {
        if cost(side_log2) < cost(best) {
            best = side_log2;
        }
    }
    best
}
