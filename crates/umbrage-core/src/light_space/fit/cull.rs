//! Culling to need: which casters can shadow what is seen, and where on the map.
//!
//! A coarse grid over the map holds, for each cell, the farthest receiver that looks up the map there. A caster matters
//! if somewhere it lies before that: tested with its box, so that one too many may be kept, but never one too few.

use crate::{
    Geometry, Light, View,
    light_space::fit::map_space::{MapBounds, MapPolygon, MapSpace, clip},
};
use glam::{DVec2, DVec3, Vec3};
use std::ops::Range;

/// Cells along each side: finer ones tell more casters apart, but cost more to fill and to query.
const CELLS: usize = 64;
/// Texels added to what kernels reach: one to the corner of the receiver's own texel, one half for what lookups in 32 bits
/// round.
const OWN_TEXEL: f64 = 1.5;
/// Greatest slope, clip depth a texel, at which taps are taken to follow the receiver's plane away from the light: that of
/// the techniques' own biases.
const STEEPEST: f64 = 0.1;
/// Least depth, as a fraction of the map's range, by which a bias may move a receiver away from the light.
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
    /// Returns the reach, where the first caster has rank `first` and the last receiver has rank `last`. A search for
    /// blockers goes as far as the light's extent lets a caster at the near plane matter to the last receiver, which is
    /// linear in the ranks: `extent (last - first)`.
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

/// Returns the world positions of what is seen to receive, if that is known.
pub(super) fn seen(view: &View<'_>) -> Option<Vec<Vec3>> {
    view.receivers.map(|seen| seen.positions().collect())
}

/// Where something receives, map space: seen points, or boxes around runs of triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Receiving {
    points: Vec<DVec3>,
    boxes: Vec<MapBounds>,
}

impl Receiving {
    /// Returns what may receive within `column`: those of the `seen` points (world space) that lie there; if they aren't known,
    /// boxes around all receivers.
    pub(super) fn new(
        seen: Option<&[Vec3]>,
        geometry: &Geometry,
        space: &MapSpace,
        column: &MapBounds,
    ) -> Self {
        let mut out = Self::default();
        match seen {
            Some(points) => {
                out.points.reserve(points.len());
                out.points
                    .extend(points.iter().filter_map(|&p| space.point_within(p, column)));
            }
            None => {
                let boxes = geometry
                    .chunk_bounds()
                    .of(geometry.receivers())
                    .map(|(_, b)| space.block(&b));
                out.boxes
                    .extend(boxes.filter(|b| b.meets(column)).map(|b| b.within(column)));
            }
        }
        out
    }

    /// Returns what fills a box.
    pub(super) fn within(b: MapBounds) -> Self {
        Self {
            points: Vec::new(),
            boxes: vec![b],
        }
    }

    /// Returns a box around all of it.
    pub(super) fn bounds(&self) -> MapBounds {
        let points = MapBounds::around(self.points.iter().copied());
        self.boxes.iter().fold(points, |all, b| all.union(b))
    }
}

/// Returns the least rank that any caster may have within `column`; none if there are no casters.
pub(super) fn first_rank(geometry: &Geometry, space: &MapSpace, column: &MapBounds) -> Option<f64> {
    let chunks = geometry.chunk_bounds().of(geometry.casters());
    chunks
        .map(|(_, b)| space.block(&b))
        .filter(|b| b.meets(column))
        .map(|b| b.min.z)
        .reduce(f64::min)
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
    /// Of each cell, in rows: the greatest rank of the receivers whose lookups may go there; minus infinity without any.
    last: Vec<f64>,
}

impl<'a> Need<'a> {
    /// Returns none if nothing receives.
    pub(super) fn new(
        space: MapSpace,
        geometry: &'a Geometry,
        receivers: &Receiving,
        reach: &Reach,
    ) -> Option<Self> {
        let all = receivers.bounds();
        if all.is_empty() {
            return None;
        }
        let column = all.column(reach.across);
        let side = (column.max - column.min).truncate();
        let cell = (side / CELLS as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let last = vec![f64::NEG_INFINITY; CELLS * CELLS];
        let mut out = Self {
            space,
            geometry,
            behind: reach.behind,
            column,
            shown: column,
            cell,
            last,
        };
        for &p in &receivers.points {
            let i = out.cell_of(p);
            out.last[i] = out.last[i].max(p.z);
        }
        for b in &receivers.boxes {
            for i in out.cells(b) {
                out.last[i] = out.last[i].max(b.max.z);
            }
        }
        out.widen((reach.across / cell).ceil());
        Some(out)
    }

    /// Returns the same for a map that shows no more than `column`: lookups that leave it find nothing, so casters beside it
    /// do not count.
    pub(super) fn on_map(self, column: &MapBounds) -> Self {
        Self {
            shown: self.column.within(column),
            ..self
        }
    }

    /// Returns the index of the cell on which a point falls.
    fn cell_of(&self, p: DVec3) -> usize {
        let position = (p - self.column.min).truncate() / self.cell;
        // Casts saturate: what lies outside counts for the outermost cells.
        let x = (position.x as usize).min(CELLS - 1);
        let y = (position.y as usize).min(CELLS - 1);
        y * CELLS + x
    }

    /// Returns the indices of the cells that a box covers.
    fn cells(&self, b: &MapBounds) -> impl Iterator<Item = usize> + use<> {
        let first = self.cell_of(b.min);
        let last = self.cell_of(b.max);
        let columns = first % CELLS..last % CELLS + 1;
        let rows = first / CELLS..last / CELLS + 1;
        rows.flat_map(move |y| columns.clone().map(move |x| y * CELLS + x))
    }

    /// Lets every receiver count in cells up to `by` (cells across and up) away.
    fn widen(&mut self, by: DVec2) {
        // Casts saturate here, too.
        let columns = (by.x as usize).min(CELLS);
        let rows = (by.y as usize).min(CELLS);
        self.last = spread(&self.last, columns, |i, step| i % CELLS + step < CELLS, 1);
        self.last = spread(&self.last, rows, |i, step| i / CELLS + step < CELLS, CELLS);
    }

    /// Returns whether something with this box may matter.
    fn matters(&self, b: &MapBounds) -> bool {
        b.meets(&self.shown) && self.cells(b).any(|i| self.last[i] + self.behind >= b.min.z)
    }

    /// Returns runs of casters of which some may matter, and a box around each.
    fn runs(&self) -> impl Iterator<Item = (Range<u32>, MapBounds)> + '_ {
        let runs = self.geometry.chunk_bounds().of(self.geometry.casters());
        runs.map(|(run, b)| (run, self.space.block(&b)))
            .filter(|(_, b)| self.matters(b))
    }

    /// Returns a box around those parts of casters that may matter; empty if there are none.
    pub(super) fn around_casters(&self) -> MapBounds {
        let mut found = MapBounds::EMPTY;
        for (run, b) in self.runs() {
            if adds_nothing(&b.within(&self.shown), &found) {
                continue;
            }
            for triangle in run {
                let polygon = self.space.triangle(self.geometry.corners(triangle));
                let b = MapBounds::around(polygon.corners().iter().copied());
                if adds_nothing(&b.within(&self.shown), &found) || !self.matters(&b) {
                    continue;
                }
                let is_shown_whole = b.within(&self.shown) == b;
                let part = if is_shown_whole {
                    b
                } else {
                    self.part(&polygon)
                };
                found = found.union(&part);
            }
        }
        found
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
    pub(super) fn casters(&self) -> impl Iterator<Item = u32> + '_ {
        self.runs().flat_map(|(run, _)| run).filter(|&id| {
            let polygon = self.space.triangle(self.geometry.corners(id));
            self.matters(&MapBounds::around(polygon.corners().iter().copied()))
        })
    }
}

/// Returns whether a box lies, sideways, within the box `found` and no nearer to the light.
fn adds_nothing(b: &MapBounds, found: &MapBounds) -> bool {
    b.min.cmpge(found.min).all() && b.max.truncate().cmple(found.max.truncate()).all()
}

/// Returns for each cell the greatest value up to `by` cells away in one direction. The next cell in that direction is `stride`
/// entries on; `fits(i, n)` tells whether entry `i` has a neighbour n cells on.
fn spread(
    values: &[f64],
    by: usize,
    fits: impl Fn(usize, usize) -> bool,
    stride: usize,
) -> Vec<f64> {
    let mut out = values.to_vec();
    let mut reached = 0;
    // Steps grow: what has spread by r each way leaves no gap after a step of up to r + 1 both ways.
    while reached < by {
        let step = (reached + 1).min(by - reached);
        let before = out.clone();
        for i in (0..before.len()).filter(|&i| fits(i, step)) {
            let next = i + step * stride;
            out[i] = out[i].max(before[next]);
            out[next] = out[next].max(before[i]);
        }
        reached += step;
    }
    out
}
