//! Culling of the casters that can't shadow a visible receiver, and the part of the map that the
//! others cover.
//!
//! A coarse grid over the map stores, for each cell, the farthest receiver that looks up the map
//! there. A caster matters if some part of it is before that receiver. The test uses the caster's
//! box: it is conservative, and may keep too many casters, but never too few.

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

/// Cells along each side: finer ones separate more casters, but cost more to fill and to query.
const CELLS: usize = 64;
/// Greatest number of tiles of visible points that are tested point by point; beyond that, sorting
/// all points into cells is faster.
const MAX_TILES_OPENED: usize = 512;
/// Number of parts into which visible points are divided for threads.
const PARTS: usize = 16;
/// Texels added to the reach of kernels: one to the corner of the receiver's texel, one half for
/// the rounding of 32-bit lookups.
const OWN_TEXEL: f64 = 1.5;
/// Greatest slope, clip depth per texel, up to which samples are assumed to follow the receiver's
/// plane away from the light. It is the limit of the techniques' biases.
const STEEPEST: f64 = 0.1;
/// Least depth, as a fraction of the map's range, by which a bias may move a receiver away from the
/// light.
const DEEPEST_BIAS: f64 = 1.0 / 64.0;

/// Distance from a receiver within which lookups may find casters that change the result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Lateral distance, map space.
    pub(super) across: DVec2,
    /// Distance behind the receiver, ranks.
    pub(super) behind: f64,
}

/// Parameters of a lookup other than the receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lookups {
    /// Sides of a texel, map space; no smaller than those of the final map.
    pub(super) texel: DVec2,
    /// Reach of the kernel beyond the receiver's texel, texels.
    pub(super) margin: f64,
    /// Rounding of positions, map space.
    pub(super) rounding: f64,
    /// Greatest tangent on the map; 0 without perspective.
    pub(super) tangent: f64,
}

impl Lookups {
    /// Returns the reach, given the rank `first` of the first caster and `last` of the last
    /// receiver. A blocker search has the radius within which a caster at the near plane can shade
    /// the last receiver, given the light's extent. It is linear in the ranks:
    /// `extent (last - first)`.
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

/// Receiving geometry in map space: visible points, or boxes around runs of triangles.
#[derive(Clone, Debug)]
pub(super) struct Receiving<'a> {
    seen: Option<SeenOnMap<'a>>,
    boxes: Vec<MapBounds>,
    bounds: MapBounds,
}

/// The visible points within `column`.
#[derive(Clone, Copy, Debug)]
struct SeenOnMap<'a> {
    seen: &'a SeenPoints<'a>,
    space: MapSpace,
    column: MapBounds,
}

impl<'a> Receiving<'a> {
    /// Returns the receiving geometry within `column`: the `seen` points there, or boxes around all
    /// receivers if the points aren't known.
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

    /// Returns boxes, clipped to `column`, around all receiving triangles.
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
                boxes.push(b.intersection(column));
            }
        }
        Self {
            bounds: boxes.iter().fold(MapBounds::EMPTY, |all, b| all.union(b)),
            seen: None,
            boxes,
        }
    }

    /// Returns receivers that fill a box.
    pub(super) fn from_bounds(b: MapBounds) -> Self {
        Self {
            seen: None,
            boxes: vec![b],
            bounds: b,
        }
    }

    /// Returns a box around all receivers.
    pub(super) fn bounds(&self) -> MapBounds {
        self.bounds
    }
}

impl SeenOnMap<'_> {
    /// Calls `visit` for the tiles whose enclosing boxes all satisfy `is_wanted`, until it returns
    /// true. Returns whether it did.
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

/// Returns a lower bound of the ranks of casters within `column`; `None` if there are no casters.
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

/// Test of casters against receivers, using the grid of the module documentation.
#[derive(Clone, Debug)]
pub(super) struct Need<'a> {
    space: MapSpace,
    geometry: &'a Geometry,
    /// See [`Reach::behind`].
    behind: f64,
    /// Area of possible lookups, divided by the grid.
    column: MapBounds,
    /// Area in which casters count: the part of the column that the map covers.
    shown: MapBounds,
    /// Sides of a cell, map space.
    cell: DVec2,
    /// Greatest rank of the receivers whose lookups may reach each cell, row by row; minus infinity
    /// without any. If visible points are known, the ranks are those of the boxes around their
    /// tiles.
    last: Vec<f64>,
    seen: Option<SeenInCells<'a>>,
}

/// Refinement from boxes around tiles to single visible points. Most casters are before some point
/// of each tile or behind the whole tile, so few tiles need to be tested.
#[derive(Clone, Debug)]
struct SeenInCells<'a> {
    points: SeenOnMap<'a>,
    /// Like [`Need::last`], for one point per tile.
    certain: Vec<f64>,
    /// Reach of lookups, in cells along each axis.
    reach: [usize; 2],
    /// Number of tiles tested so far.
    tiles_opened: Cell<usize>,
    /// Like [`Need::last`], for all points. Computed once too many tiles were tested.
    exact: OnceCell<Vec<f64>>,
}

impl<'a> Need<'a> {
    /// Returns `None` if there are no receivers.
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
        // Divide the area of possible lookups into cells.
        let column = all.column(reach.across);
        let side = (column.max - column.min).truncate();
        let cell = (side / CELLS as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        // Casts saturate: lookups may reach the whole grid.
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
        // Write the ranks of visible points.
        if let Some(points) = receivers.seen {
            let [certain, possible] = out.last_of_tiles(&points);
            out.last = possible;
            out.seen = Some(SeenInCells {
                points,
                certain: widen_values(&certain, reach_in_cells),
                reach: reach_in_cells,
                tiles_opened: Cell::new(0),
                exact: OnceCell::new(),
            });
        }
        // Write the ranks of boxes.
        for b in &receivers.boxes {
            for i in out.cells(b) {
                out.last[i] = out.last[i].max(b.max.z);
            }
        }
        out.last = widen_values(&out.last, reach_in_cells);
        Some(out)
    }

    /// Returns two grids of greatest ranks: of one visible point per tile, and of the boxes around
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

    /// Returns `self` for a map that covers only `column`: lookups outside it find nothing, so
    /// casters outside don't count.
    pub(super) fn on_map(self, column: &MapBounds) -> Self {
        Self {
            shown: self.column.intersection(column),
            ..self
        }
    }

    fn column_and_row(&self, p: DVec3) -> [usize; 2] {
        column_and_row(&self.column, self.cell, p)
    }

    fn cells(&self, b: &MapBounds) -> impl Iterator<Item = usize> + use<> {
        cells(&self.column, self.cell, b)
    }

    /// Returns whether geometry with this box may matter.
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

    /// Returns the grid of greatest ranks of all visible points.
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
                // Use `for_each`: a `for` loop would check for the end of the tile's row at each
                // point.
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
        widen_values(&last, seen.reach)
    }

    /// Returns whether geometry with this box is before a visible point whose lookups may reach it.
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

    /// Calls `visit` in order for runs with casters that may matter, with a box around each run.
    /// Skips boxes for which `is_known` is true; it must then be true of everything inside.
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

    /// Returns a box around the parts of casters that may matter; empty if there are none.
    pub(super) fn around_casters(&self) -> MapBounds {
        let mut found = MapBounds::EMPTY;
        let adds_nothing =
            |found: &MapBounds, b: &MapBounds| adds_nothing(&b.intersection(&self.shown), found);
        self.visit_runs(&mut found, adds_nothing, |found, run| {
            self.geometry.box_tree().count(&run);
            for triangle in run {
                let part = self.part_that_matters(triangle, |b| adds_nothing(found, b));
                *found = found.union(&part);
            }
        });
        found
    }

    /// Returns the least rank of the parts of casters that may matter; infinity if there are none.
    /// Equals that of [`Need::around_casters`], but takes less time.
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

    /// Returns a box around the part of a caster that may matter. Empty if there is none, or if
    /// `is_known` is true of the box around the caster.
    fn part_that_matters(&self, caster: u32, is_known: impl Fn(&MapBounds) -> bool) -> MapBounds {
        let corners = self.geometry.corners(caster);
        // Test the box before building a polygon: most casters are known.
        let whole = self.space.whole_triangle_bounds(&corners);
        if whole.is_some_and(|b| is_known(&b)) {
            return MapBounds::EMPTY;
        }
        let polygon = self.space.triangle(corners);
        let b = MapBounds::from_points(polygon.corners().iter().copied());
        if is_known(&b) || !self.matters(&b) {
            return MapBounds::EMPTY;
        }
        let is_shown_whole = b.intersection(&self.shown) == b;
        if is_shown_whole {
            b
        } else {
            self.part(&polygon)
        }
    }

    /// Returns a box around the part of a caster that is laterally within `shown`.
    fn part(&self, polygon: &MapPolygon) -> MapBounds {
        let min = self.shown.min;
        let max = self.shown.max;
        let cut = clip(polygon, DVec3::X, min.x);
        let cut = clip(&cut, DVec3::NEG_X, -max.x);
        let cut = clip(&cut, DVec3::Y, min.y);
        let cut = clip(&cut, DVec3::NEG_Y, -max.y);
        MapBounds::from_points(cut.corners().iter().copied())
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
                    self.matters(&MapBounds::from_points(polygon.corners().iter().copied()))
                }));
            },
        );
        ids
    }
}

/// Returns the column and the row of the cell that contains a point, in a grid of cells with sides
/// `cell` over `grid`.
fn column_and_row(grid: &MapBounds, cell: DVec2, p: DVec3) -> [usize; 2] {
    let position = (p - grid.min).truncate() / cell;
    // Casts saturate: points outside count for the outermost cells.
    [position.x, position.y].map(|along| (along as usize).min(CELLS - 1))
}

/// Returns the index of the cell that contains a point; parameters as for [`column_and_row`].
fn cell_of(grid: &MapBounds, cell: DVec2, p: DVec3) -> usize {
    let [column, row] = column_and_row(grid, cell, p);
    row * CELLS + column
}

/// Returns the indices of the cells that a box covers; parameters as for [`column_and_row`].
fn cells(grid: &MapBounds, cell: DVec2, b: &MapBounds) -> impl Iterator<Item = usize> + use<> {
    let [first_column, first_row] = column_and_row(grid, cell, b.min);
    let [last_column, last_row] = column_and_row(grid, cell, b.max);
    let columns = first_column..last_column + 1;
    let rows = first_row..last_row + 1;
    rows.flat_map(move |y| columns.clone().map(move |x| y * CELLS + x))
}

/// Returns whether a box is laterally within the box `found`, and no nearer to the light.
fn adds_nothing(b: &MapBounds, found: &MapBounds) -> bool {
    b.min.cmpge(found.min).all() && b.max.truncate().cmple(found.max.truncate()).all()
}

/// Returns, for each cell, the greatest value up to `reach` cells away along each axis.
fn widen_values(values: &[f64], reach: [usize; 2]) -> Vec<f64> {
    let [columns, rows] = reach.map(|cells| cells.min(CELLS));
    let mut out = values.to_vec();
    for row in out.chunks_mut(CELLS) {
        spread(row, columns, 1);
    }
    spread(&mut out, rows, CELLS);
    out
}

/// Replaces each cell by the greatest value up to `by` cells away in one direction, in which
/// consecutive cells are `stride` entries apart.
fn spread(values: &mut [f64], by: usize, stride: usize) {
    let mut reached = 0;
    // Use growing steps: values spread by r each way leave no gap after a step of up to r + 1 both
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
