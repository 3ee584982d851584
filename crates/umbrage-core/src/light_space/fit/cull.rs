//! Culling to need: which casters can shadow what is seen, and where on the map.
//!
//! A coarse grid over the map holds, for each cell, the farthest receiver that looks up the map
//! there. A caster matters if somewhere it lies before that: tested with its box, so that one too
//! many may be kept, but never one too few.

use crate::{
    gbuffer::seen_points::SeenPoints,
    geometry::{Geometry, aabb::Aabb},
    light_space::fit::{
        map_space::{MapBounds, MapPolygon, MapSpace, clip},
        points::seen_on,
    },
    parallel::prelude::*,
    scene::light::Light,
};
use glam::{DVec2, DVec3};
use std::{
    cell::{Cell, OnceCell},
    ops::Range,
};

/// Cells along each side: finer ones tell more casters apart, but cost more to fill and to query.
const CELLS: usize = 64;
/// Tiles of seen points that are looked into one by one; beyond that, sorting all points into cells
/// takes less time.
const MAX_TILES_OPENED: usize = 512;
/// Parts into which seen points are shared out among threads.
const PARTS: usize = 16;
/// Texels added to what kernels reach: one to the corner of the receiver's own texel, one half for
/// what lookups in 32 bits round.
const OWN_TEXEL: f64 = 1.5;
/// Greatest slope, clip depth a texel, at which taps are taken to follow the receiver's plane away
/// from the light: that of the techniques' own biases.
const STEEPEST: f64 = 0.1;
/// Least depth, as a fraction of the map's range, by which a bias may move a receiver away from the
/// light.
const DEEPEST_BIAS: f64 = 1.0 / 64.0;

/// How far from a receiver lookups may find casters that change its answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Sideways, map space.
    pub(super) across: DVec2,
    /// Behind the receiver, ranks.
    pub(super) behind: f64,
}

/// What a lookup depends on beside the receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lookups {
    /// Sides of a texel, map space; no smaller than the map's will be.
    pub(super) texel: DVec2,
    /// Texels that a kernel reaches beyond the receiver's own.
    pub(super) margin: f64,
    /// Rounding of positions, map space.
    pub(super) rounding: f64,
    /// Greatest tangent on the map; 0 without perspective.
    pub(super) tangent: f64,
}

impl Lookups {
    /// Returns the reach, where the first caster has rank `first` and the last receiver has rank
    /// `last`. A search for blockers goes as far as the light's extent lets a caster at the near
    /// plane matter to the last receiver, which is linear in the ranks: `extent (last - first)`.
    pub(super) fn reach(&self, light: &Light, first: f64, last: f64) -> Reach {
        let range = (last - first).max(0.0);
        let search = extent(light) * (1.0 + self.tangent) * range;
        let across = self.texel * (self.margin + OWN_TEXEL) + search + self.rounding;
        let texels = (across / self.texel.max(DVec2::splat(f64::MIN_POSITIVE))).max_element();
        Reach {
            across,
            behind: range * (STEEPEST * texels).clamp(DEEPEST_BIAS, 1.0),
        }
    }
}

/// Returns half the size of a light: a tangent for directional light, metres for others.
fn extent(light: &Light) -> f64 {
    match *light {
        Light::Directional {
            angular_diameter, ..
        } => (f64::from(angular_diameter) * 0.5).tan(),
        Light::Spot { radius, .. } | Light::Point { radius, .. } | Light::Disc { radius, .. } => {
            f64::from(radius)
        }
        Light::Rect { half_u, half_v, .. } => {
            f64::from(half_u.length()) + f64::from(half_v.length())
        }
    }
}

/// Where something receives, map space: seen points, or boxes around runs of triangles.
#[derive(Clone, Debug)]
pub(super) struct Receiving<'a> {
    seen: Option<SeenOnMap<'a>>,
    boxes: Vec<MapBounds>,
    bounds: MapBounds,
}

/// Those seen points that lie within `column`.
#[derive(Clone, Copy, Debug)]
struct SeenOnMap<'a> {
    seen: &'a SeenPoints<'a>,
    space: MapSpace,
    column: MapBounds,
}

impl<'a> Receiving<'a> {
    /// Returns what may receive within `column`: those of the `seen` points that lie there; if they
    /// aren't known, boxes around all receivers.
    pub(super) fn new(
        seen: Option<&'a SeenPoints<'_>>,
        geometry: &Geometry,
        space: &MapSpace,
        column: &MapBounds,
    ) -> Self {
        let Some(seen) = seen else {
            return Self::of_triangles(geometry, space, column);
        };
        Self {
            bounds: seen_on(space, seen, column),
            seen: Some(SeenOnMap {
                seen,
                space: *space,
                column: *column,
            }),
            boxes: Vec::new(),
        }
    }

    /// Returns boxes, cut by `column`, around all triangles that receive.
    fn of_triangles(geometry: &Geometry, space: &MapSpace, column: &MapBounds) -> Self {
        let mut boxes = Vec::new();
        let mut walk = geometry.box_tree().walk(geometry.receivers());
        while let Some(block) = walk.next() {
            if block.run.is_none() {
                if space.group(&block.bounds).meets(column) {
                    walk.enter(&block);
                }
                continue;
            }
            let b = space.block(&block.bounds);
            if b.meets(column) {
                boxes.push(b.within(column));
            }
        }
        Self {
            bounds: boxes.iter().fold(MapBounds::EMPTY, |all, b| all.union(b)),
            seen: None,
            boxes,
        }
    }

    /// Returns what fills a box.
    pub(super) fn within(b: MapBounds) -> Self {
        Self {
            seen: None,
            boxes: vec![b],
            bounds: b,
        }
    }

    /// Returns a box around all of it.
    pub(super) fn bounds(&self) -> MapBounds {
        self.bounds
    }
}

impl SeenOnMap<'_> {
    /// Passes the tiles for which `is_wanted` is true of the boxes around them, one inside the
    /// other, to `visit`, until that returns true. Returns whether it did.
    fn any_tile(
        &self,
        is_wanted: impl Fn(&MapBounds) -> bool,
        mut visit: impl FnMut(Range<u32>, &MapBounds) -> bool,
    ) -> bool {
        let mut walk = self.seen.tree().walk(self.seen.entries());
        while let Some(block) = walk.next() {
            let b = self.space.group(&block.bounds);
            if !b.meets(&self.column) || !is_wanted(&b) {
                continue;
            }
            match &block.run {
                Some(tile) if visit(tile.clone(), &b) => return true,
                Some(_) => {}
                None => walk.enter(&block),
            }
        }
        false
    }

    /// Returns the points of a tile, map space.
    fn points_in(&self, tile: &Range<u32>) -> impl Iterator<Item = DVec3> {
        let points = self.seen.points_in(tile);
        points.filter_map(|p| self.space.point_within(p, &self.column))
    }
}

/// Returns the least rank that any caster may have within `column`; none if there are no casters.
pub(super) fn first_rank(geometry: &Geometry, space: &MapSpace, column: &MapBounds) -> Option<f64> {
    let least_in = |b: &MapBounds| {
        if b.meets(column) {
            b.min.z
        } else {
            f64::INFINITY
        }
    };
    let first = geometry.box_tree().least(
        geometry.casters(),
        |b| least_in(&space.group(b)),
        |_, b| least_in(&space.block(b)),
    );
    first.is_finite().then_some(first)
}

/// Decides which casters matter to some receivers: the grid of the module's description.
#[derive(Clone, Debug)]
pub(super) struct Need<'a> {
    space: MapSpace,
    geometry: &'a Geometry,
    /// As [`Reach::behind`].
    behind: f64,
    /// Where lookups may go; the grid divides it.
    column: MapBounds,
    /// Where casters count: the part of the column that the map shows.
    shown: MapBounds,
    /// Sides of a cell, map space.
    cell: DVec2,
    /// Of each cell, in rows: the greatest rank of the receivers whose lookups may go there; minus
    /// infinity without any. Where seen points are known, that of the boxes around tiles of them.
    last: Vec<f64>,
    seen: Option<SeenInCells<'a>>,
}

/// What tells the cells' seen points from the boxes around tiles of them. Most casters lie before
/// some point of each tile or behind the whole tile, so that few tiles need to be looked into.
#[derive(Clone, Debug)]
struct SeenInCells<'a> {
    points: SeenOnMap<'a>,
    /// As [`Need::last`], of one point a tile.
    certain: Vec<f64>,
    /// How many cells across and up lookups reach.
    reach: [usize; 2],
    /// How many tiles were looked into.
    tiles_opened: Cell<usize>,
    /// As [`Need::last`], of all points: found once too many tiles were looked into.
    exact: OnceCell<Vec<f64>>,
}

impl<'a> Need<'a> {
    /// Returns none if nothing receives.
    pub(super) fn new(
        space: MapSpace,
        geometry: &'a Geometry,
        receivers: &Receiving<'a>,
        reach: &Reach,
    ) -> Option<Self> {
        let all = receivers.bounds();
        if all.is_empty() {
            return None;
        }
        let column = all.column(reach.across);
        let side = (column.max - column.min).truncate();
        let cell = (side / CELLS as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        // Casts saturate: lookups may reach everywhere.
        let cells_across = (reach.across / cell).ceil();
        let reach_in_cells = [cells_across.x as usize, cells_across.y as usize];
        let mut out = Self {
            space,
            geometry,
            behind: reach.behind,
            column,
            shown: column,
            cell,
            last: vec![f64::NEG_INFINITY; CELLS * CELLS],
            seen: None,
        };
        if let Some(points) = receivers.seen {
            let [certain, possible] = out.last_of_tiles(&points);
            out.last = possible;
            out.seen = Some(SeenInCells {
                points,
                certain: widened(&certain, reach_in_cells),
                reach: reach_in_cells,
                tiles_opened: Cell::new(0),
                exact: OnceCell::new(),
            });
        }
        for b in &receivers.boxes {
            for i in out.cells(b) {
                out.last[i] = out.last[i].max(b.max.z);
            }
        }
        out.last = widened(&out.last, reach_in_cells);
        Some(out)
    }

    /// Returns the greatest ranks, in each cell, of one seen point a tile, and of the boxes around
    /// tiles.
    fn last_of_tiles(&self, points: &SeenOnMap<'_>) -> [Vec<f64>; 2] {
        let mut certain = vec![f64::NEG_INFINITY; CELLS * CELLS];
        let mut possible = certain.clone();
        points.any_tile(
            |_| true,
            |tile, b| {
                for i in self.cells(b) {
                    possible[i] = possible[i].max(b.max.z);
                }
                if let Some(p) = points.points_in(&tile).next() {
                    let i = cell_of(&self.column, self.cell, p);
                    certain[i] = certain[i].max(p.z);
                }
                false
            },
        );
        [certain, possible]
    }

    /// Returns the same for a map that shows no more than `column`: lookups that leave it find
    /// nothing, so casters beside it do not count.
    pub(super) fn on_map(self, column: &MapBounds) -> Self {
        Self {
            shown: self.column.within(column),
            ..self
        }
    }

    fn column_and_row(&self, p: DVec3) -> [usize; 2] {
        column_and_row(&self.column, self.cell, p)
    }

    fn cells(&self, b: &MapBounds) -> impl Iterator<Item = usize> + use<> {
        cells(&self.column, self.cell, b)
    }

    /// Returns whether something with this box may matter.
    fn matters(&self, b: &MapBounds) -> bool {
        let is_before = |last: &[f64]| self.cells(b).any(|i| last[i] + self.behind >= b.min.z);
        if !b.meets(&self.shown) || !is_before(&self.last) {
            return false;
        }
        match &self.seen {
            None => true,
            Some(seen) if is_before(&seen.certain) => true,
            Some(seen) if seen.tiles_opened.get() < MAX_TILES_OPENED => {
                self.is_before_a_point(b, seen)
            }
            Some(seen) => is_before(seen.exact.get_or_init(|| self.last_of_points(seen))),
        }
    }

    /// Returns what the cells hold of all seen points.
    fn last_of_points(&self, seen: &SeenInCells<'_>) -> Vec<f64> {
        let points = &seen.points;
        let mut tiles: Vec<(Range<u32>, MapBounds)> = Vec::new();
        points.any_tile(
            |_| true,
            |tile, b| {
                tiles.push((tile, *b));
                false
            },
        );
        let nothing = || vec![f64::NEG_INFINITY; CELLS * CELLS];
        let grid = self.column;
        let cell = self.cell;
        let last_of = |tiles: &[(Range<u32>, MapBounds)]| {
            let mut last = nothing();
            for (tile, b) in tiles {
                if cells(&grid, cell, b).all(|i| last[i] >= b.max.z) {
                    continue;
                }
                // Not `for`: it would ask at each point whether the tile's row goes on.
                points.points_in(tile).for_each(|p| {
                    let i = cell_of(&grid, cell, p);
                    last[i] = last[i].max(p.z);
                });
            }
            last
        };
        let parts = tiles.par_chunks(tiles.len().div_ceil(PARTS).max(1));
        let last = parts.map(last_of).reduce(nothing, |a, b| {
            a.into_iter().zip(b).map(|(a, b)| a.max(b)).collect()
        });
        widened(&last, seen.reach)
    }

    /// Returns whether something with this box lies before a seen point whose lookups may go there.
    fn is_before_a_point(&self, b: &MapBounds, seen: &SeenInCells<'_>) -> bool {
        let [first_column, first_row] = self.column_and_row(b.min);
        let [last_column, last_row] = self.column_and_row(b.max);
        let [columns, rows] = seen.reach;
        let may_look_there = |low: DVec3, high: DVec3| {
            let [low_column, low_row] = self.column_and_row(low);
            let [high_column, high_row] = self.column_and_row(high);
            low_column <= last_column.saturating_add(columns)
                && first_column <= high_column.saturating_add(columns)
                && low_row <= last_row.saturating_add(rows)
                && first_row <= high_row.saturating_add(rows)
        };
        let is_behind = |rank: f64| rank + self.behind >= b.min.z;
        seen.points.any_tile(
            |tiles| is_behind(tiles.max.z) && may_look_there(tiles.min, tiles.max),
            |tile, _| {
                seen.tiles_opened.set(seen.tiles_opened.get() + 1);
                let mut points = seen.points.points_in(&tile);
                points.any(|p| is_behind(p.z) && may_look_there(p, p))
            },
        )
    }

    /// Passes the casters of runs of which some may matter, in order, to `visit`, with a box around
    /// each run. Passes over runs in boxes for which `is_known` is true, which must then be so of
    /// what lies in them.
    fn visit_runs<T>(
        &self,
        state: &mut T,
        is_known: impl Fn(&T, &MapBounds) -> bool,
        mut visit: impl FnMut(&mut T, Range<u32>),
    ) {
        let mut walk = self.geometry.box_tree().walk(self.geometry.casters());
        while let Some(block) = walk.next() {
            let b = match block.run {
                Some(_) => self.space.block(&block.bounds),
                None => self.space.group(&block.bounds),
            };
            if !self.matters(&b) || is_known(state, &b) {
                continue;
            }
            match &block.run {
                Some(run) => visit(state, run.clone()),
                None => walk.enter(&block),
            }
        }
    }

    /// Returns a box around those parts of casters that may matter; empty if there are none.
    pub(super) fn around_casters(&self) -> MapBounds {
        let mut found = MapBounds::EMPTY;
        let adds_nothing =
            |found: &MapBounds, b: &MapBounds| adds_nothing(&b.within(&self.shown), found);
        self.visit_runs(&mut found, adds_nothing, |found, run| {
            self.geometry.box_tree().count(&run);
            for triangle in run {
                let part = self.part_that_matters(triangle, |b| adds_nothing(found, b));
                *found = found.union(&part);
            }
        });
        found
    }

    /// Returns the least rank of those parts of casters that may matter; infinity if there are
    /// none. It is that of [`Need::around_casters`], and takes less time.
    pub(super) fn first_rank(&self) -> f64 {
        let least = Cell::new(f64::INFINITY);
        let bound = |b: &Aabb| {
            let b = self.space.group(b);
            if b.min.z < least.get() && self.matters(&b) {
                b.min.z
            } else {
                f64::INFINITY
            }
        };
        let boxes = self.geometry.box_tree();
        boxes.least(self.geometry.casters(), bound, |run, _| {
            boxes.count(&run);
            for triangle in run {
                let part = self.part_that_matters(triangle, |b| b.min.z >= least.get());
                least.set(least.get().min(part.min.z));
            }
            least.get()
        })
    }

    /// Returns a box around the part of a caster that may matter; empty if there is none, or if
    /// `is_known` is true of the box around the caster.
    fn part_that_matters(&self, caster: u32, is_known: impl Fn(&MapBounds) -> bool) -> MapBounds {
        let corners = self.geometry.corners(caster);
        // Most casters are known, which their box says before a polygon is made.
        let whole = self.space.whole_triangle_bounds(&corners);
        if whole.is_some_and(|b| is_known(&b)) {
            return MapBounds::EMPTY;
        }
        let polygon = self.space.triangle(corners);
        let b = MapBounds::around(polygon.corners().iter().copied());
        if is_known(&b) || !self.matters(&b) {
            return MapBounds::EMPTY;
        }
        let is_shown_whole = b.within(&self.shown) == b;
        if is_shown_whole {
            b
        } else {
            self.part(&polygon)
        }
    }

    /// Returns a box around the part of a caster that lies within `shown`, sideways.
    fn part(&self, polygon: &MapPolygon) -> MapBounds {
        let min = self.shown.min;
        let max = self.shown.max;
        let cut = clip(polygon, DVec3::X, min.x);
        let cut = clip(&cut, DVec3::NEG_X, -max.x);
        let cut = clip(&cut, DVec3::Y, min.y);
        let cut = clip(&cut, DVec3::NEG_Y, -max.y);
        MapBounds::around(cut.corners().iter().copied())
    }

    /// Returns the ids of the casters that may matter.
    #[cfg(feature = "testing")]
    pub(super) fn casters(&self) -> Vec<u32> {
        let mut ids = Vec::new();
        self.visit_runs(
            &mut ids,
            |_, _| false,
            |ids, run| {
                ids.extend(run.filter(|&id| {
                    let polygon = self.space.triangle(self.geometry.corners(id));
                    self.matters(&MapBounds::around(polygon.corners().iter().copied()))
                }));
            },
        );
        ids
    }
}

/// Returns the column and the row of the cell on which a point falls, of a grid of cells with sides
/// `cell` over `grid`.
fn column_and_row(grid: &MapBounds, cell: DVec2, p: DVec3) -> [usize; 2] {
    let position = (p - grid.min).truncate() / cell;
    // Casts saturate: what lies outside counts for the outermost cells.
    [position.x, position.y].map(|along| (along as usize).min(CELLS - 1))
}

/// Returns the index of the cell on which a point falls; parameters as of [`column_and_row`].
fn cell_of(grid: &MapBounds, cell: DVec2, p: DVec3) -> usize {
    let [column, row] = column_and_row(grid, cell, p);
    row * CELLS + column
}

/// Returns the indices of the cells that a box covers; parameters as of [`column_and_row`].
fn cells(grid: &MapBounds, cell: DVec2, b: &MapBounds) -> impl Iterator<Item = usize> + use<> {
    let [first_column, first_row] = column_and_row(grid, cell, b.min);
    let [last_column, last_row] = column_and_row(grid, cell, b.max);
    let columns = first_column..last_column + 1;
    let rows = first_row..last_row + 1;
    rows.flat_map(move |y| columns.clone().map(move |x| y * CELLS + x))
}

/// Returns whether a box lies, sideways, within the box `found` and no nearer to the light.
fn adds_nothing(b: &MapBounds, found: &MapBounds) -> bool {
    b.min.cmpge(found.min).all() && b.max.truncate().cmple(found.max.truncate()).all()
}

/// Returns for each cell the greatest value up to `reach` cells away across and up.
fn widened(values: &[f64], reach: [usize; 2]) -> Vec<f64> {
    let [columns, rows] = reach.map(|cells| cells.min(CELLS));
    let mut out = values.to_vec();
    for row in out.chunks_mut(CELLS) {
        spread(row, columns, 1);
    }
    spread(&mut out, rows, CELLS);
    out
}

/// Puts into each cell the greatest value up to `by` cells away in one direction, in which the next
/// cell is `stride` entries on.
fn spread(values: &mut [f64], by: usize, stride: usize) {
    let mut reached = 0;
    // Steps grow: what has spread by r each way leaves no gap after a step of up to r + 1 both
    // ways.
    while reached < by {
        let step = (reached + 1).min(by - reached);
        let before = values.to_vec();
        let shift = (step * stride).min(values.len());
        for (value, next) in values.iter_mut().zip(&before[shift..]) {
            *value = value.max(*next);
        }
        for (value, last) in values[shift..].iter_mut().zip(&before) {
            *value = value.max(*last);
        }
        reached += step;
    }
}
