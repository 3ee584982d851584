//! The CPU half of the kernel: rays are placed on the grid in vector lanes, lists are walked one receiver at a time.

use super::{
    ExactUniforms,
    light_frame::LightFrame,
    lists::Lists,
    outline::{Outline, greater, lesser},
    tile::DEPTH_UNKNOWN,
};
use crate::lanes::batch::{BATCH, Lanes, PaddedReceivers, ReceiverBatch};
use umbrage_core::{
    Simd, SimdTask, Span,
    bvh::segment_hits,
    glam::{Vec2, Vec3, Vec4},
    light_sample::{SHORT, origin_offset, segment},
    math::dot3,
};

/// Fills `out`, as long as the span, with the light's visibility.
pub(super) fn look_up_span(
    simd: Simd,
    uniforms: &ExactUniforms,
    lists: &Lists,
    span: &Span<'_>,
    out: &mut [f32],
) {
    let mut padded = PaddedReceivers::new();
    for first in (0..out.len()).step_by(BATCH) {
        let count = BATCH.min(out.len() - first);
        let receivers = ReceiverBatch::from(span, first, &mut padded);
        let frame = &lists.frame;
        let rays = if frame.is_lamp {
            simd.run_task(Place::<true> {
                uniforms,
                frame,
                receivers: &receivers,
            })
        } else {
            simd.run_task(Place::<false> {
                uniforms,
                frame,
                receivers: &receivers,
            })
        };
        simd.run_task(Answer {
            lists,
            rays: &rays,
            own: &span.triangle[first..first + count],
            out: &mut out[first..first + count],
        });
    }
}

/// How many receivers ask a list at once.
const LANES: usize = 8;

/// A number of each receiver of a batch, and beyond its end for a last run that is not full.
type Numbers = [f32; BATCH + LANES];

/// The rays of a batch of receivers, and where they fall on the grid.
struct Rays {
    origin: [Numbers; 3],
    vector: [Numbers; 3],
    direction: [Numbers; 3],
    depth: Numbers,
    /// What the plane's function is multiplied by, and what is added.
    factor: Numbers,
    summand: Numbers,
    /// The number of the tile; [`NO_TILE`] outside of the grid.
    tile: Lanes<i32>,
    /// Across and down the tile, 0 to 1.
    within: [Numbers; 2],
}

/// Numbers from here to twice this are whole.
const WHOLE: f32 = 8_388_608.0;
const WHOLE_BITS: u32 = 1 << 23;

/// [`Rays::tile`] of receivers that face away from the light.
const FACES_AWAY: i32 = -1;

/// [`Rays::tile`] of receivers outside of the grid.
const NO_TILE: i32 = -2;

impl Rays {
    fn new() -> Self {
        let zeros = [0.0; BATCH + LANES];
        Self {
            origin: [zeros; 3],
            vector: [zeros; 3],
            direction: [zeros; 3],
            depth: zeros,
            factor: zeros,
            summand: zeros,
            tile: [NO_TILE; BATCH],
            within: [zeros; 2],
        }
    }

    #[inline(always)]
    fn at(numbers: &[Numbers; 3], i: usize) -> Vec3 {
        Vec3::new(numbers[0][i], numbers[1][i], numbers[2][i])
    }
}

/// Places a batch of receivers.
struct Place<'a, const LAMP: bool> {
    uniforms: &'a ExactUniforms,
    frame: &'a LightFrame,
    receivers: &'a ReceiverBatch<'a>,
}

impl<const LAMP: bool> SimdTask for Place<'_, LAMP> {
    type Output = Rays;

    #[inline(always)]
    fn run(self) -> Rays {
        let mut out = Rays::new();
        let u = self.uniforms;
        let frame = *self.frame;
        let eye = u.eye.truncate();
        // Copies, so that the loop becomes one of vector instructions: what it writes can't be what it reads.
        let receivers = *self.receivers;
        let sun = segment(&u.light, Vec3::ZERO, Vec2::ZERO, u.far);
        let lamp = u.light.center.truncate();
        let [wide, high] = [frame.tiles.x as f32, frame.tiles.y as f32];
        let per_margin = u.origin.w;
        for i in 0..BATCH {
            let p = receivers.position(i);
            let n = receivers.normal(i);
            let to_eye = (eye - p).abs();
            let reach = greater(greater(to_eye.x, to_eye.y), greater(to_eye.z, u.grid.w));
            let o = p + n * origin_offset(p, reach);
            // As `segment` has it of a point.
            let d = if LAMP { (lamp - o) * SHORT } else { sun };
            let point = frame.look_up_as::<LAMP>(frame.place_as::<LAMP>(o));
            let at = (point.on_face + frame.half) * frame.tiles_a_unit;
            // A lamp's faces end where others begin. Written so that what is not a number is outside.
            let is_inside = LAMP || at.x >= 0.0 && at.y >= 0.0 && at.x < wide && at.y < high;
            let x = lesser(greater(at.x, 0.0), wide - 0.001);
            let y = lesser(greater(at.y, 0.0), high - 0.001);
            let [tile_x, tile_y] = [x.floor(), y.floor()];
            let line = point.face as f32 * high + tile_y;
            // 2^23 more has the whole number in its lowest bits: a conversion that knows no bounds.
            let tile = ((line * wide + tile_x + WHOLE).to_bits() & (WHOLE_BITS - 1)) as i32;
            for (axis, numbers) in out.origin.iter_mut().enumerate() {
                numbers[i] = o[axis];
            }
            for (axis, numbers) in out.vector.iter_mut().enumerate() {
                numbers[i] = d[axis];
            }
            for (axis, numbers) in out.direction.iter_mut().enumerate() {
                numbers[i] = point.direction[axis];
            }
            out.depth[i] = point.depth;
            out.factor[i] = if LAMP { point.depth } else { 1.0 };
            out.summand[i] = if LAMP { -per_margin } else { point.depth * per_margin };
            out.within[0][i] = x - tile_x;
            out.within[1][i] = y - tile_y;
            let tile = if is_inside { tile } else { NO_TILE };
            let faces_light = dot3(n, d) > 0.0;
            out.tile[i] = if faces_light { tile } else { FACES_AWAY };
        }
        out
    }
}

/// Answers for a batch.
struct Answer<'a> {
    lists: &'a Lists,
    rays: &'a Rays,
    own: &'a [u32],
    out: &'a mut [f32],
}

impl SimdTask for Answer<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rays = self.rays;
        let walk = Walk {
            lists: self.lists,
            rays,
            own: self.own,
        };
        let count = self.out.len();
        let mut places = CellPlaces {
            cell: [NO_CELL; BATCH],
            across: [0.0; BATCH + LANES],
            down: [0.0; BATCH + LANES],
        };
        for (i, out) in self.out.iter_mut().enumerate() {
            *out = if rays.tile[i] == FACES_AWAY { 0.0 } else { 1.0 };
            if rays.tile[i] >= 0 {
                walk.find_cell(i, &mut places);
            }
        }
        let mut runs = [Run::default(); BATCH];
        let run_count = find_runs(&places, count, &mut runs);
        let runs = &mut runs[..run_count];
        // Memory is slow, and what is asked of it at once comes at once: so all heads are read before the first list, and all lists
        // before the first outline.
        for run in runs.iter_mut() {
            walk.read_head(run);
        }
        walk.ask(runs, &places);
        for run in runs.iter() {
            let mut hidden = run.all & !run.open;
            while hidden != 0 {
                let lane = hidden.trailing_zeros();
                self.out[usize::from(run.first) + lane as usize] = 0.0;
                hidden &= hidden - 1;
            }
        }
    }
}

/// Neighbours in the same cell, which ask its list together.
#[derive(Clone, Copy, Default)]
struct Run {
    /// The batch's number of the first.
    first: u8,
    /// A bit for each.
    all: u32,
    /// The bits of those that see the light, as far as is known.
    open: u32,
    cell: u32,
    first_item: u32,
    item_count: u32,
}

/// Finds the runs of a batch of `count` receivers. Returns their number.
#[inline(always)]
fn find_runs(places: &CellPlaces, count: usize, out: &mut [Run; BATCH]) -> usize {
    let mut found = 0;
    let mut first = 0;
    while first < count {
        let cell = places.cell[first];
        let mut end = first + 1;
        while end < count && end < first + LANES && places.cell[end] == cell {
            end += 1;
        }
        if cell != NO_CELL {
            out[found].first = first as u8;
            out[found].all = (1_u32 << (end - first)) - 1;
            out[found].cell = cell;
            found += 1;
        }
        first = end;
    }
    found
}

/// A caster that may hide the light from some of a run.
#[derive(Clone, Copy, Default)]
struct Candidate {
    run: u32,
    /// As in the item.
    caster: u32,
    outline: u32,
}

/// The greatest number below -1.
const BELOW_MISS: f32 = -1.000_000_1;

/// Most candidates that wait at a time.
const WAITING: usize = 256;

/// The cells of a batch of receivers, and where in them the receivers lie, in 256ths of their sides.
struct CellPlaces {
    cell: Lanes<u32>,
    across: Numbers,
    down: Numbers,
}

/// No cell: the receiver faces away, or lies outside of the grid.
const NO_CELL: u32 = u32::MAX;

/// The numbers of a run of receivers.
type Window = [f32; LANES];

#[inline(always)]
fn window(numbers: &Numbers, first: usize) -> Window {
    let mut out = [0.0; LANES];
    out.copy_from_slice(&numbers[first..first + LANES]);
    out
}

/// Returns a bit for each number that is greater than the limit.
#[inline(always)]
fn bits_above(numbers: &Window, limit: f32) -> u32 {
    let limit = Vec4::splat(limit);
    let low = Vec4::from_slice(&numbers[..4]).cmpgt(limit).bitmask();
    let high = Vec4::from_slice(&numbers[4..]).cmpgt(limit).bitmask();
    low | high << 4
}

/// Returns the least and the greatest of those numbers whose bits are set.
#[inline(always)]
fn range_of(numbers: &Window, bits: u32) -> [f32; 2] {
    let mut low = [f32::INFINITY; LANES];
    let mut high = [f32::NEG_INFINITY; LANES];
    for lane in 0..LANES {
        let is_set = bits & (1 << lane) != 0;
        low[lane] = if is_set { numbers[lane] } else { f32::INFINITY };
        high[lane] = if is_set { numbers[lane] } else { f32::NEG_INFINITY };
    }
    let half = |all: &Window| [Vec4::from_slice(&all[..4]), Vec4::from_slice(&all[4..])];
    let [a, b] = half(&low);
    let [c, d] = half(&high);
    [a.min(b).min_element(), c.max(d).max_element()]
}

/// Walks lists.
struct Walk<'a> {
    lists: &'a Lists,
    rays: &'a Rays,
    own: &'a [u32],
}

impl Walk<'_> {
    /// Finds the cell of a receiver that has a tile.
    #[inline(always)]
    fn find_cell(&self, i: usize, out: &mut CellPlaces) {
        let rays = self.rays;
        let [first_cell, side_log2] = pair_at(&self.lists.tiles, rays.tile[i] as usize);
        let side = (1_u32 << side_log2) as f32;
        let across = rays.within[0][i] * side;
        let down = rays.within[1][i] * side;
        let [x, y] = [across as i32, down as i32];
        out.cell[i] = first_cell + ((y as u32) << side_log2) + x as u32;
        out.across[i] = across - x as f32;
        out.down[i] = down - y as f32;
    }

    /// Reads where a run's list is, and hides the light from those behind its cover.
    #[inline(always)]
    fn read_head(&self, run: &mut Run) {
        let [first_item, item_count, covered_behind, _] = self.lists.cells[run.cell as usize];
        let depth = window(&self.rays.depth, run.first.into());
        run.open = run.all & !bits_above(&depth, f32::from_bits(covered_behind));
        run.first_item = first_item;
        run.item_count = item_count;
    }

    /// Asks the lists of runs.
    #[inline(always)]
    fn ask(&self, runs: &mut [Run], places: &CellPlaces) {
        let mut waiting = [Candidate::default(); WAITING];
        let mut count = 0;
        for number in 0..runs.len() {
            let run = runs[number];
            if run.open == 0 || run.item_count == 0 {
                continue;
            }
            let first = run.first.into();
            let [_, deepest] = range_of(&window(&self.rays.depth, first), run.open);
            let byte = |numbers: &Numbers| {
                range_of(&window(numbers, first), run.open).map(|v| (v * 256.0) as i32 as u32)
            };
            let [across, down] = [byte(&places.across), byte(&places.down)];
            let end = (run.first_item + run.item_count) as usize;
            let list = &self.lists.items[run.first_item as usize..end];
            for row in list {
                if f32::from_bits(row[2]) > deepest {
                    break;
                }
                let [low_x, low_y, high_x, high_y] = row[3].to_le_bytes().map(u32::from);
                let is_beside = (across[1] < low_x)
                    | (down[1] < low_y)
                    | (across[0] > high_x)
                    | (down[0] > high_y);
                waiting[count] = Candidate {
                    run: number as u32,
                    caster: row[0],
                    outline: row[1],
                };
                count += usize::from(!is_beside);
                if count == WAITING {
                    self.ask_candidates(&waiting, runs);
                    count = 0;
                }
            }
        }
        self.ask_candidates(&waiting[..count], runs);
    }

    /// Hides the light from those receivers of runs whose rays meet a candidate, their own triangle apart.
    #[inline(always)]
    fn ask_candidates(&self, candidates: &[Candidate], runs: &mut [Run]) {
        for candidate in candidates {
            let run = &mut runs[candidate.run as usize];
            if run.open == 0 {
                continue;
            }
            let first = usize::from(run.first);
            let caster = candidate.caster & !DEPTH_UNKNOWN;
            let outline = Outline::at(&self.lists.outlines, candidate.outline);
            let least = self.least(&outline, candidate.caster != caster, first);
            // Not less than -1.
            let mut near = run.open & bits_above(&least, BELOW_MISS);
            if near == 0 {
                continue;
            }
            let sure = bits_above(&least, 1.0);
            while near != 0 {
                let lane = near.trailing_zeros();
                near &= near - 1;
                let i = first + lane as usize;
                if self.own[i] == caster {
                    continue;
                }
                if sure & (1 << lane) != 0 || self.meets(i, caster) {
                    run.open &= !(1 << lane);
                }
            }
        }
    }

    /// Returns the least of an outline's functions for a run of receivers.
    #[inline(always)]
    fn least(&self, outline: &Outline, is_depth_unknown: bool, first: usize) -> Window {
        let rays = self.rays;
        let [x, y, z] = [0, 1, 2].map(|axis| window(&rays.direction[axis], first));
        let mut out = [0.0; LANES];
        for lane in 0..LANES {
            let value = |k: usize| outline.x[k] * x[lane] + outline.y[k] * y[lane] + outline.z[k] * z[lane];
            out[lane] = lesser(value(0), lesser(value(1), value(2)));
        }
        if is_depth_unknown {
            let depth = window(&rays.depth, first);
            for lane in 0..LANES {
                let value = if depth[lane] > outline.z.w { 2.0 } else { 0.0 };
                out[lane] = lesser(out[lane], value);
            }
        } else {
            let factor = window(&rays.factor, first);
            let summand = window(&rays.summand, first);
            for lane in 0..LANES {
                let plane = outline.x.w * x[lane] + outline.y.w * y[lane] + outline.z.w * z[lane];
                out[lane] = lesser(out[lane], plane * factor[lane] + summand[lane]);
            }
        }
        out
    }

    /// The triangle test of rays.
    #[inline(never)]
    fn meets(&self, i: usize, caster: u32) -> bool {
        let first = 3 * caster as usize;
        let rows = &self.lists.corners[first..first + 3];
        let corner = |i: usize| {
            let row = rows[i].map(f32::from_bits);
            Vec3::new(row[0], row[1], row[2])
        };
        let o = Rays::at(&self.rays.origin, i);
        let d = Rays::at(&self.rays.vector, i);
        segment_hits(o, d, corner(0), corner(1), corner(2))
    }
}

/// Returns entry `i` of a table with two a row.
#[inline(always)]
fn pair_at(rows: &[[u32; 4]], i: usize) -> [u32; 2] {
    let row = &rows[i / 2];
    let place = 2 * (i % 2);
    [row[place], row[place + 1]]
}
