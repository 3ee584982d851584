//! CPU half of the kernel. Rays are placed on the grid, and their cells found, in vector lanes.
//! Neighbours in one cell walk its list together.

use super::{
    holes::CasterHoles,
    item_key::{CellBox, KEY_STEPS, ends_list, may_hide, receiver_word},
    light_frame::{ExactUniforms, LightFrame},
    lists::Lists,
};
use crate::lanes::{
    batch::{BATCH, Lanes, PaddedReceivers, ReceiverBatch},
    whole::{floor, whole_to_u32},
};
use std::ops::Range;
use umbrage_core::{
    NO_TRIANGLE, Simd, SimdTask, Span,
    bvh::{SEGMENT_LANES, SegmentArrays, longest_axis},
    glam::{Vec2, Vec3, Vec3A, Vec4},
    light_sample::{SHORT, ray_origin, segment},
    math::{dot3, greater, lesser},
};

/// Data that receivers query.
#[derive(Clone, Copy)]
pub(super) struct LookupInput<'a> {
    pub(super) uniforms: &'a ExactUniforms,
    pub(super) lists: &'a Lists,
    /// Alpha test of the casters; `None` if none is alpha-tested.
    pub(super) holes: Option<CasterHoles<'a>>,
}

/// Cell that a receiver queries, for analysing lookup costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueriedCell {
    /// Index among all cells of the light.
    pub number: u32,
    /// Number of casters in the cell's list.
    pub length: u32,
    /// True if one caster hides the light from all receivers of the cell at this receiver's depth.
    /// The list isn't queried then.
    pub is_covered: bool,
}

/// Fills `out`, which is as long as the span, with the light's visibility.
pub(super) fn look_up_span(
    simd: Simd,
    requested: LookupInput<'_>,
    span: &Span<'_>,
    out: &mut [f32],
) {
    let LookupInput {
        uniforms,
        lists,
        holes,
    } = requested;
    let mut padded = PaddedReceivers::new();
    for first in (0..out.len()).step_by(BATCH) {
        let count = BATCH.min(out.len() - first);
        let receivers = ReceiverBatch::from(span, first, &mut padded);
        let rays = place(simd, uniforms, &lists.frame, &receivers);
        simd.run_task(Answer {
            lists,
            holes,
            rays: &rays,
            own: &span.triangle[first..first + count],
            out: &mut out[first..first + count],
        });
    }
}

/// Fills `out`, which is as long as the span, with the cells that its receivers query. An entry is
/// `None` if a receiver faces away from the light or nothing can block it.
pub(super) fn cells_of_span(
    uniforms: &ExactUniforms,
    lists: &Lists,
    span: &Span<'_>,
    out: &mut [Option<QueriedCell>],
) {
    let mut padded = PaddedReceivers::new();
    for first in (0..out.len()).step_by(BATCH) {
        let receivers = ReceiverBatch::from(span, first, &mut padded);
        let rays = place(Simd::Native, uniforms, &lists.frame, &receivers);
        let walk = CellWalk {
            lists,
            holes: None,
            rays: &rays,
            own: &[],
        };
        let places = walk.find_cells();
        let rest = &mut out[first..];
        for (i, out) in rest.iter_mut().take(BATCH).enumerate() {
            let number = places.cell[i];
            if number == NO_CELL {
                *out = None;
                continue;
            }
            let cell = lists.cells[number as usize];
            let end = lists.cells[number as usize + 1][0];
            *out = Some(QueriedCell {
                number,
                length: end - cell[0],
                is_covered: rays.depth[i] > f32::from_bits(cell[1]),
            });
        }
    }
}

/// Places a batch of receivers on the grid.
fn place(
    simd: Simd,
    uniforms: &ExactUniforms,
    frame: &LightFrame,
    receivers: &ReceiverBatch<'_>,
) -> CellRays {
    if frame.is_lamp {
        simd.run_task(LookupPlace::<true> {
            uniforms,
            frame,
            receivers,
        })
    } else {
        simd.run_task(LookupPlace::<false> {
            uniforms,
            frame,
            receivers,
        })
    }
}

/// Number of receivers that query a list at once; more neighbours are seldom in one cell.
const LANES: usize = SEGMENT_LANES;

/// Length of arrays with a value for each receiver of a batch. A last partial run extends beyond
/// the batch.
const PADDED: usize = BATCH + LANES;

/// Array with a value for each receiver of a batch.
type CellNumbers = [f32; PADDED];

/// Rays of a batch of receivers, and their positions on the grid.
struct CellRays {
    segments: SegmentArrays<PADDED>,
    depth: CellNumbers,
    /// Number of the tile; [`NO_TILE`] outside the grid.
    tile: Lanes<i32>,
    /// Position across and down the tile, 0 to 1.
    within: [CellNumbers; 2],
}

/// Greatest number below 1. Its product with a small integer is still less than that integer.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Least float from which, up to twice its value, all floats are integers.
const WHOLE: f32 = 8_388_608.0;
const WHOLE_BITS: u32 = 1 << 23;

/// Value of [`CellRays::tile`] for receivers that face away from the light.
const FACES_AWAY: i32 = -1;

/// Value of [`CellRays::tile`] for receivers outside the grid.
const NO_TILE: i32 = -2;

impl CellRays {
    fn new() -> Self {
        Self {
            segments: SegmentArrays::default(),
            depth: [0.0; PADDED],
            tile: [NO_TILE; BATCH],
            within: [[0.0; PADDED]; 2],
        }
    }
}

/// Task that places a batch of receivers on the grid.
struct LookupPlace<'a, const LAMP: bool> {
    uniforms: &'a ExactUniforms,
    frame: &'a LightFrame,
    receivers: &'a ReceiverBatch<'a>,
}

impl<const LAMP: bool> SimdTask for LookupPlace<'_, LAMP> {
    type Output = CellRays;

    #[inline(always)]
    fn run(self) -> CellRays {
        let mut out = CellRays::new();
        let u = self.uniforms;
        let frame = *self.frame;
        let eye = u.eye.truncate();
        // Copy the inputs, so that the loop is vectorised: its outputs can't alias them.
        let receivers = *self.receivers;
        let sun = segment(&u.light, Vec3::ZERO, Vec2::ZERO, u.far);
        let lamp = u.light.center.truncate();
        let [wide, high] = [frame.tiles.x as f32, frame.tiles.y as f32];
        for i in 0..BATCH {
            let p = receivers.position(i);
            let n = receivers.normal(i);
            let o = ray_origin(p, n, eye, u.grid.w);
            // Compute the segment to a point as in `segment`.
            let d = if LAMP { (lamp - o) * SHORT } else { sun };
            // Receivers of a cell share the longest axis of their rays.
            let point = frame.look_up_as::<LAMP>(frame.place_as::<LAMP>(o), longest_axis(d));
            let at = (point.on_face + frame.half) * frame.tiles_a_unit;
            // Faces of a point light are adjacent, so every position is inside one. The comparison
            // puts NaN outside.
            let is_inside = LAMP || at.x >= 0.0 && at.y >= 0.0 && at.x < wide && at.y < high;
            let x = lesser(greater(at.x, 0.0), wide * BELOW_ONE);
            let y = lesser(greater(at.y, 0.0), high * BELOW_ONE);
            let [tile_x, tile_y] = [x.floor(), y.floor()];
            let line = point.face as f32 * high + tile_y;
            // Adding 2^23 moves the integer into the lowest bits: a conversion without range
            // checks.
            let tile = ((line * wide + tile_x + WHOLE).to_bits() & (WHOLE_BITS - 1)) as i32;
            out.segments.set(i, o, d);
            out.depth[i] = point.depth;
            out.within[0][i] = x - tile_x;
            out.within[1][i] = y - tile_y;
            let tile = if is_inside { tile } else { NO_TILE };
            let faces_light = dot3(n, d) > 0.0;
            out.tile[i] = if faces_light { tile } else { FACES_AWAY };
        }
        out
    }
}

/// Task that computes the visibilities of a batch.
struct Answer<'a> {
    lists: &'a Lists,
    holes: Option<CasterHoles<'a>>,
    rays: &'a CellRays,
    own: &'a [u32],
    out: &'a mut [f32],
}

impl SimdTask for Answer<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rays = self.rays;
        let walk = CellWalk {
            lists: self.lists,
            holes: self.holes,
            rays,
            own: self.own,
        };
        let count = self.out.len();
        // Start from the surfaces that face away.
        for (out, tile) in self.out.iter_mut().zip(&rays.tile) {
            *out = if *tile == FACES_AWAY { 0.0 } else { 1.0 };
        }
        // Group neighbours in the same cell.
        let places = walk.find_cells();
        let mut runs = [CellRun::default(); BATCH];
        let run_count = find_runs(&places, count, &mut runs);
        let runs = &mut runs[..run_count];
        // Batch independent memory reads, which overlap. Read all heads before the first list, the
        // first items of all lists before the rest of any, and the corners of many casters before
        // the first test.
        for run in runs.iter_mut() {
            walk.read_head(run);
        }
        for run in runs.iter_mut() {
            walk.read_first_item(run);
        }
        walk.query_lists(runs, &places);
        // Store the blocked receivers.
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

/// Run of neighbours in the same cell, which query its list together.
#[derive(Clone, Copy, Default)]
struct CellRun {
    /// Index of the first receiver in the batch, and their number.
    first: u8,
    count: u8,
    /// Bits of all receivers of the run.
    all: u32,
    /// Bits of the receivers that are not known to be blocked.
    open: u32,
    cell: u32,
    first_item: u32,
    end_item: u32,
    /// Word of the first item.
    first_word: u32,
    depth_base: f32,
    steps_a_depth: f32,
}

/// Finds the runs of a batch of `count` receivers. Returns their number.
#[inline(always)]
fn find_runs(places: &CellPlaces, count: usize, out: &mut [CellRun; BATCH]) -> usize {
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
            out[found].count = (end - first) as u8;
            out[found].all = (1_u32 << (end - first)) - 1;
            out[found].cell = cell;
            found += 1;
        }
        first = end;
    }
    found
}

/// Caster that may hide the light from some receivers of a run.
#[derive(Clone, Copy, Default)]
struct CasterCandidate {
    run: u32,
    caster: u32,
}

/// Maximum number of pending candidates.
const WAITING: usize = 64;

/// Cells of a batch of receivers, and the receivers' positions in them as fractions of their sides.
struct CellPlaces {
    cell: Lanes<u32>,
    across: CellNumbers,
    down: CellNumbers,
}

impl CellPlaces {
    fn new() -> Self {
        Self {
            cell: [NO_CELL; BATCH],
            across: [0.0; PADDED],
            down: [0.0; PADDED],
        }
    }
}

/// Value for receivers that face away or are outside the grid.
const NO_CELL: u32 = u32::MAX;

/// Returns the least and the greatest of the receivers' values.
#[inline(always)]
fn range_of(numbers: &[f32]) -> [f32; 2] {
    let mut out = [numbers[0]; 2];
    for &number in &numbers[1..] {
        out = [lesser(out[0], number), greater(out[1], number)];
    }
    out
}

/// Returns the least and the greatest step of positions in a cell, which are fractions of its side.
#[inline(always)]
fn step_range(places: &[f32]) -> [u32; 2] {
    let [least, greatest] = range_of(places);
    [
        (least * KEY_STEPS) as i32 as u32,
        (greatest * KEY_STEPS) as i32 as u32,
    ]
}

/// Data for walking lists.
struct CellWalk<'a> {
    lists: &'a Lists,
    holes: Option<CasterHoles<'a>>,
    rays: &'a CellRays,
    own: &'a [u32],
}

impl CellWalk<'_> {
    /// Finds the cells of a batch of receivers.
    #[inline(always)]
    fn find_cells(&self) -> CellPlaces {
        let rays = self.rays;
        let mut first_cells = [0; BATCH];
        let mut sides_log2 = [0; BATCH];
        for i in 0..BATCH {
            // Use any tile for receivers without one.
            let tile = rays.tile[i].max(0) as usize;
            [first_cells[i], sides_log2[i]] = pair_at(&self.lists.tiles, tile);
        }
        let mut out = CellPlaces::new();
        for i in 0..BATCH {
            let side = two_to_the(sides_log2[i]);
            let across = rays.within[0][i] * side;
            let down = rays.within[1][i] * side;
            let [x, y] = [floor(across), floor(down)];
            let cell = (whole_to_u32(y) << sides_log2[i]) + whole_to_u32(x) + first_cells[i];
            out.cell[i] = if rays.tile[i] < 0 { NO_CELL } else { cell };
            out.across[i] = across - x;
            out.down[i] = down - y;
        }
        out
    }

    /// Reads the location of a run's list, and blocks the receivers behind its cover.
    #[inline(always)]
    fn read_head(&self, run: &mut CellRun) {
        let cell = run.cell as usize;
        let [first_item, covered_behind, depth_base, steps_a_depth] = self.lists.cells[cell];
        let covered_behind = Vec4::splat(f32::from_bits(covered_behind));
        let depth = Vec4::from_slice(&self.rays.depth[run.first.into()..][..LANES]);
        run.open = run.all & !depth.cmpgt(covered_behind).bitmask();
        run.first_item = first_item;
        run.end_item = self.lists.cells[cell + 1][0];
        run.depth_base = f32::from_bits(depth_base);
        run.steps_a_depth = f32::from_bits(steps_a_depth);
    }

    /// Reads the word of a run's first item.
    #[inline(always)]
    fn read_first_item(&self, run: &mut CellRun) {
        if run.open != 0 && run.first_item != run.end_item {
            let [_, word] = pair_at(&self.lists.items, run.first_item as usize);
            run.first_word = word;
        }
    }

    /// Queries the lists of runs.
    #[inline(always)]
    fn query_lists(&self, runs: &mut [CellRun], places: &CellPlaces) {
        let mut waiting = [CasterCandidate::default(); WAITING];
        let mut count = 0;
        for number in 0..runs.len() {
            let run = runs[number];
            if run.open == 0 || run.first_item == run.end_item {
                continue;
            }
            let first = usize::from(run.first);
            let lanes = first..first + usize::from(run.count);
            let [_, deepest] = range_of(&self.rays.depth[lanes.clone()]);
            // Skip receivers in front of all casters.
            if deepest < run.depth_base {
                continue;
            }
            // Compute the query word of the run.
            let depth_step = (deepest - run.depth_base) * run.steps_a_depth;
            let depth_step = lesser(depth_step, KEY_STEPS - 1.0) as i32 as u32;
            let across = step_range(&places.across[lanes.clone()]);
            let down = step_range(&places.down[lanes.clone()]);
            let bounds = CellBox {
                low: [across[0], down[0]],
                high: [across[1], down[1]],
            };
            let querying = receiver_word(bounds, depth_step);
            if ends_list(run.first_word, querying) {
                continue;
            }
            let own = self.own_of_all(&lanes);
            // Walk the list, and collect candidates.
            for item in run.first_item..run.end_item {
                let [caster, word] = pair_at(&self.lists.items, item as usize);
                if ends_list(word, querying) {
                    break;
                }
                waiting[count] = CasterCandidate {
                    run: number as u32,
                    caster,
                };
                count += usize::from(may_hide(word, querying) & (caster != own));
                if count == WAITING {
                    self.query_candidates(&waiting, runs);
                    count = 0;
                }
            }
        }
        self.query_candidates(&waiting[..count], runs);
    }

    /// Returns the triangle that contains all of some receivers. Returns no caster's id if they are
    /// on several triangles.
    #[inline(always)]
    fn own_of_all(&self, lanes: &Range<usize>) -> u32 {
        let own = &self.own[lanes.clone()];
        let is_one = own.iter().all(|&id| id == own[0]);
        if is_one { own[0] } else { NO_TRIANGLE }
    }

    /// Returns whether a ray, which hits a caster, hits it at a transparent texel.
    #[inline(always)]
    fn is_hole_met(&self, ray: usize, caster: u32, corners: [Vec3; 3]) -> bool {
        let o = || self.rays.segments.origin(ray);
        self.holes
            .is_some_and(|holes| holes.are_met(caster, corners, o()))
    }

    /// Blocks those receivers of runs whose rays hit a candidate, except their own triangle.
    #[inline(always)]
    fn query_candidates(&self, candidates: &[CasterCandidate], runs: &mut [CellRun]) {
        // Corners are scattered over memory. Independent reads overlap, so read all before the
        // first test.
        let mut corners = [[Vec3A::ZERO; 3]; WAITING];
        for (corners, candidate) in corners.iter_mut().zip(candidates) {
            let rows = &self.lists.corners[3 * candidate.caster as usize..][..3];
            *corners = [corner(&rows[0]), corner(&rows[1]), corner(&rows[2])];
        }
        let mut querying = None;
        let mut segments = self.rays.segments.four(0);
        for (corners, candidate) in corners.iter().zip(candidates) {
            let caster = candidate.caster;
            let run = &mut runs[candidate.run as usize];
            if run.open == 0 {
                continue;
            }
            let first = usize::from(run.first);
            // Candidates of one run are consecutive.
            if querying != Some(candidate.run) {
                querying = Some(candidate.run);
                segments = self.rays.segments.four(first);
            }
            let corners = [
                Vec3::from(corners[0]),
                Vec3::from(corners[1]),
                Vec3::from(corners[2]),
            ];
            let mut hits = run.open & segments.hits(corners);
            while hits != 0 {
                let lane = hits.trailing_zeros();
                hits &= hits - 1;
                let ray = first + lane as usize;
                if self.own[ray] != caster && !self.is_hole_met(ray, caster, corners) {
                    run.open &= !(1 << lane);
                }
            }
        }
    }
}

/// Returns the corner in a row of [`Lists::corners`].
#[inline(always)]
fn corner(row: &[u32; 4]) -> Vec3A {
    Vec3A::from_vec4(Vec4::new(
        f32::from_bits(row[0]),
        f32::from_bits(row[1]),
        f32::from_bits(row[2]),
        f32::from_bits(row[3]),
    ))
}

/// Returns 2 to the power of a small integer, by setting a float's exponent.
#[inline(always)]
fn two_to_the(power: u32) -> f32 {
    const EXPONENT_OF_ONE: u32 = 127;
    f32::from_bits((power + EXPONENT_OF_ONE) << 23)
}

/// Returns entry `i` of a table with two entries per row.
#[inline(always)]
fn pair_at(rows: &[[u32; 4]], i: usize) -> [u32; 2] {
    let row = &rows[i / 2];
    let place = 2 * (i % 2);
    [row[place], row[place + 1]]
}
