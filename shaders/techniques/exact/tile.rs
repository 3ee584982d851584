//! Lists of the cells of one tile.

use super::{
    item_key::{CellBox, KEY_STEPS, KEY_STEPS_LOG2, item_word},
    light_frame::LightFrame,
    outline::{Traits, outline_of},
    touches::{STEPS, Touch},
};
use umbrage_core::{
    Geometry,
    glam::{Vec2, Vec3, Vec4},
};

/// Maximum number of cells along a tile's side, as a power of two.
const FINEST: u32 = 7;

/// Mean list length from which finer cells are considered. They are used if the number of items
/// grows by a factor below [`WORTHWHILE`].
const LONG: f32 = 48.0;
const WORTHWHILE: f32 = 2.0;

/// One triangle of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Item {
    /// Index in the list of triangles.
    pub(super) caster: u32,
    /// Least depth in the cell, minus the margin.
    pub(super) nearest: f32,
    /// Bounding box in the cell, in [`KEY_STEPS`] of its side.
    pub(super) bounds: CellBox,
}

/// List of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// First item; the last one is before the next cell's first.
    pub(super) first: u32,
    /// Depth beyond which everything is in shadow: the greatest depth, plus the margin, of the
    /// nearest triangle that covers the whole cell.
    pub(super) covered_behind: f32,
    /// Start of the depth steps, and one over their width.
    pub(super) depth_base: f32,
    pub(super) steps_a_depth: f32,
}

/// Cells of a tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tile {
    pub(super) first_cell: u32,
    /// Number of cells along a side, as a power of two.
    pub(super) side_log2: u32,
}

/// Position of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct TilePlace {
    pub(super) face: u32,
    pub(super) x: u32,
    pub(super) y: u32,
}

/// Lists of some tiles.
#[derive(Debug, Default)]
pub(super) struct TileLists {
    pub(super) tiles: Vec<Tile>,
    pub(super) cells: Vec<Cell>,
    /// Caster and its [`item_word`].
    pub(super) items: Vec<[u32; 2]>,
}

/// Relative costs of building and querying lists.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// Cost of building one item of a list.
    pub(super) item: f32,
    /// Cost of building one cell.
    pub(super) cell: f32,
    /// Cost of testing one item once.
    pub(super) test: f32,
    /// Number of receivers that query in a tile.
    pub(super) receivers: f32,
}

/// Scratch memory that is reused for each tile.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    touches: Vec<Touch>,
    /// Items and their cells, in the order of discovery.
    found: Vec<(u32, Item)>,
    counts: Vec<u32>,
    covered: Vec<f32>,
    sorted: Vec<Item>,
}

impl Scratch {
    /// Begins a tile and discards the previous one's touches.
    pub(super) fn clear(&mut self) {
        self.touches.clear();
    }

    /// Adds touches of the tile.
    pub(super) fn add(&mut self, touches: &[Touch]) {
        self.touches.extend_from_slice(touches);
    }

    /// Builds the tile's lists.
    pub(super) fn finish(
        &mut self,
        frame: &LightFrame,
        geometry: &Geometry,
        place: TilePlace,
        weights: &Weights,
        out: &mut TileLists,
    ) {
        let side_log2 = best_side(&self.touches, weights);
        out.tiles.push(Tile {
            first_cell: out.cells.len() as u32,
            side_log2,
        });
        let cells = 1_usize << (2 * side_log2);
        self.counts.clear();
        self.counts.resize(cells, 0);
        self.covered.clear();
        self.covered.resize(cells, f32::INFINITY);
        self.found.clear();
        let grid = CellGrid::new(frame, place, side_log2);
        for i in 0..self.touches.len() {
            let touch = self.touches[i];
            let range = CellRange::of_touch(&touch, side_log2);
            if range.is_small() && !touch.is_large {
                // Use all cells: testing which of them it misses costs more than occasional useless
                // tests.
                for cell in range.cells() {
                    self.push(&touch, side_log2, cell, touch.nearest);
                }
            } else {
                let traits = outline_of(frame, geometry, touch.caster);
                let may_cover = !geometry.has_holes(touch.caster);
                self.add_by_outline(frame, &grid, &touch, &traits, may_cover);
            }
        }
        self.emit(out);
    }

    /// Adds a triangle to the cells that its outline touches, and records the cells that it covers.
    fn add_by_outline(
        &mut self,
        frame: &LightFrame,
        grid: &CellGrid,
        touch: &Touch,
        traits: &Traits,
        may_cover: bool,
    ) {
        let side_log2 = grid.side_log2;
        let [across, down, summand] = traits.outline.on_face(frame.is_lamp, grid.face);
        let at_tile = summand + across * grid.low.x + down * grid.low.y;
        let [across, down] = [across * grid.step, down * grid.step];
        // Compute the differences from a cell's first corner to the extremes, which are at corners
        // for linear functions.
        let to_greatest = across.max(Vec4::ZERO) + down.max(Vec4::ZERO);
        let to_least = across.min(Vec4::ZERO) + down.min(Vec4::ZERO);
        for cell in CellRange::of_touch(touch, side_log2).cells() {
            let [cx, cy] = cell;
            let at_cell = at_tile + down * cy as f32 + across * cx as f32;
            let greatest = at_cell + to_greatest;
            if greatest.truncate().cmplt(Vec3::NEG_ONE).any() {
                continue;
            }
            if !traits.knows_depth {
                self.push(touch, side_log2, cell, touch.nearest);
                continue;
            }
            let least = at_cell + to_least;
            let nearest = frame.nearest_of_plane(least.w, greatest.w);
            self.push(touch, side_log2, cell, nearest.max(touch.nearest));
            if may_cover && least.truncate().cmpgt(Vec3::ONE).all() {
                let covered = &mut self.covered[((cy << side_log2) + cx) as usize];
                *covered = covered.min(frame.farthest_of_plane(least.w, greatest.w));
            }
        }
    }

    #[inline(always)]
    fn push(&mut self, touch: &Touch, side_log2: u32, cell: [u32; 2], nearest: f32) {
        let item = Item {
            caster: touch.caster,
            nearest,
            bounds: bounds_in_cell(touch, side_log2, cell),
        };
        let number = (cell[1] << side_log2) + cell[0];
        self.found.push((number, item));
        self.counts[number as usize] += 1;
    }

    /// Sorts the found items by cell and depth, and drops those behind the cell's cover.
    fn emit(&mut self, out: &mut TileLists) {
        let Self {
            found,
            counts,
            covered,
            sorted,
            ..
        } = self;
        // Compute the destination of each cell's items: the counts become ends, and filling from
        // the back turns them into starts.
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
        // Write each cell's list, sorted by depth.
        for (i, &covered_behind) in covered.iter().enumerate() {
            let begin = counts[i] as usize;
            let end = counts
                .get(i + 1)
                .map_or(sorted.len(), |&next| next as usize);
            let list = &mut sorted[begin..end];
            sort_by_depth(list);
            let first = out.items.len() as u32;
            // Drop items behind the cover.
            let kept = list
                .iter()
                .take_while(|item| item.nearest <= covered_behind);
            let count = kept.count();
            // Choose the depth steps.
            let depth_base = list.first().map_or(0.0, |item| item.nearest);
            let deepest = list[..count].last().map_or(0.0, |item| item.nearest);
            let steps_a_depth = (KEY_STEPS - 1.0) / (deepest - depth_base).max(f32::MIN_POSITIVE);
            let steps_a_depth = if steps_a_depth.is_finite() {
                steps_a_depth
            } else {
                0.0
            };
            for item in &list[..count] {
                // Round down, so that the step is no deeper than the receiver's own, which uses the
                // same arithmetic. It grows with depth, so no caster is skipped.
                let depth = ((item.nearest - depth_base) * steps_a_depth) as u32;
                let word = item_word(item.bounds, depth.min(KEY_STEPS as u32 - 1));
                out.items.push([item.caster, word]);
            }
            out.cells.push(Cell {
                first,
                covered_behind,
                depth_base,
                steps_a_depth,
            });
        }
    }
}

/// Sorts a list, which is mostly short, from near to far.
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

/// Returns the best subdivision of a tile: the least total cost of building lists, which finer
/// cells raise, and of querying, which they lower.
fn best_side(touches: &[Touch], weights: &Weights) -> u32 {
    // A triangle of area A in a box of w x h cells touches A + w + h + 1 of them on average (the
    // area of its Minkowski sum with a cell).
    let steps = (1_u32 << STEPS) as f32;
    let mut widths = 0.0;
    let mut areas = 0.0;
    for touch in touches {
        let wide = f32::from(touch.high[0] - touch.low[0]) / steps;
        let high = f32::from(touch.high[1] - touch.low[1]) / steps;
        widths += wide + high;
        areas += touch.area.min(wide * high);
    }
    let items = |side_log2: u32| {
        let side = (1 << side_log2) as f32;
        areas * side * side + widths * side + touches.len() as f32
    };
    let cells = |side_log2: u32| (1_u32 << (2 * side_log2)) as f32;
    let cost = |side_log2: u32| {
        let made = weights.item * items(side_log2) + weights.cell * cells(side_log2);
        let requested = weights.test * weights.receivers * items(side_log2) / cells(side_log2);
        made + requested
    };
    let mut best = 0;
    for side_log2 in 1..=FINEST {
        if cost(side_log2) < cost(best) {
            best = side_log2;
        }
    }
    // Most receivers may be in few tiles, as near a camera. So don't leave lists long if finer
    // cells shorten them.
    let is_long = |side_log2: u32| items(side_log2) > LONG * cells(side_log2);
    let shortens = |side_log2: u32| items(side_log2 + 1) < WORTHWHILE * items(side_log2);
    while best < FINEST && is_long(best) && shortens(best) {
        best += 1;
    }
    best
}

/// Grid of a tile's cells on its face.
struct CellGrid {
    face: u32,
    /// First corner of the tile, in units of a direction.
    low: Vec2,
    /// Side of a cell.
    step: f32,
    side_log2: u32,
}

impl CellGrid {
    fn new(frame: &LightFrame, place: TilePlace, side_log2: u32) -> Self {
        let tile_side = 1.0 / frame.tiles_a_unit;
        let tile = Vec2::new(place.x as f32, place.y as f32);
        Self {
            face: place.face,
            low: tile * tile_side - frame.half,
            step: tile_side / (1 << side_log2) as f32,
            side_log2,
        }
    }
}

/// Cells of a tile that a triangle's box touches.
#[derive(Clone, Copy)]
struct CellRange {
    low: [u32; 2],
    /// Inclusive.
    high: [u32; 2],
}

impl CellRange {
    #[inline(always)]
    fn of_touch(touch: &Touch, side_log2: u32) -> Self {
        let shift = STEPS - side_log2;
        Self {
            low: touch.low.map(|v| u32::from(v) >> shift),
            high: touch.high.map(|v| u32::from(v) >> shift),
        }
    }

    /// Returns whether the range is at most two cells wide and high.
    #[inline(always)]
    fn is_small(&self) -> bool {
        self.high[0] - self.low[0] <= 1 && self.high[1] - self.low[1] <= 1
    }

    #[inline(always)]
    fn cells(self) -> impl Iterator<Item = [u32; 2]> {
        let [x0, y0] = self.low;
        let [x1, y1] = self.high;
        (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| [x, y]))
    }
}

/// Returns a triangle's box clipped to a cell.
#[inline(always)]
fn bounds_in_cell(touch: &Touch, side_log2: u32, cell: [u32; 2]) -> CellBox {
    // A cell has 32 steps of its tile or more.
    let cell_log2 = STEPS - side_log2;
    let last = (1_u32 << cell_log2) - 1;
    let to_key = |step: u32| step >> (cell_log2 - KEY_STEPS_LOG2);
    let mut bounds = CellBox::default();
    for (axis, &number) in cell.iter().enumerate() {
        let start = number << cell_log2;
        let low = u32::from(touch.low[axis]).saturating_sub(start);
        let high = u32::from(touch.high[axis]).saturating_sub(start).min(last);
        bounds.low[axis] = to_key(low);
        bounds.high[axis] = to_key(high);
    }
    bounds
}
