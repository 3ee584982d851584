//! The lit areas of facets.

use crate::{
    Facets, Sides, Stated, Suns,
    clip::{self, Blocker, Receiver},
    grid::{Grid, Rectangle},
    polygons,
    stated::AnswerHash,
    suns::frame_towards,
    tree::{Projected, Scene, Stack, bounds_across},
};
use glam::{DMat3, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

/// Most facets with their centre in a tile, if it has more than one cell. A tile's memory is some
/// 150 bytes for each of these and of the facets that overlap its cells or one of them.
pub(crate) const TILE: u32 = 1 << 20;
/// Blockers above which a receiver is halved.
const MOST_BLOCKERS: usize = 128;
/// Facets of a cell above which threads share them.
const MOST_IN_SERIES: usize = 512;
/// Halvings at most, first with new searches, then with the blockers found: they may overlap or
/// meet.
const MAX_HALVINGS: u32 = 12;

/// The lit part of a facet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LitArea {
    /// Lit share of the facet's area, 0..=1. Always 0 for facets without an area.
    pub fraction: f64,
    /// Lit area, square metres.
    pub area: f64,
    /// Lit area as the sun sees it, square metres: the area times the cosine of the incidence.
    pub projected: f64,
    /// Centre of the lit part in the caller's axes, metres; the facet's centre if nothing is lit.
    pub centroid: DVec3,
}

impl Facets {
    /// Computes the lit area of each facet, and passes the areas (one per row) to `visit` with the
    /// index of the sun, one sun after another.
    ///
    /// Areas are exact but for the rounding of 64-bit numbers. Facets may cross and touch. Of
    /// facets in the same plane, the one with the lower row is lit. With [`Sides::Front`], facets
    /// that face away from the sun have no lit area. With [`Sides::Both`], the lit area is that of
    /// the side that faces the sun.
    ///
    /// Undecided are facets that are edge-on to the sun within the margin. So are those that overlap
    /// another one in the same plane, unless others darken both.
    pub fn lit_area(&self, suns: &Suns, mut visit: impl FnMut(usize, &[LitArea])) -> Stated {
        let mut stated = Stated {
            margin_m: self.margin_m(),
            identity: self.options().certify.then_some(0.0),
            ..Stated::default()
        };
        let mut hash = AnswerHash::new();
        for (i, &sun) in suns.directions().iter().enumerate() {
            let lit = self.lit_areas_towards(sun, TILE);
            let undecided = lit.undecided.iter().map(|&row| (i as u32, row));
            stated.add_undecided(undecided);
            stated.identity = stated
                .identity
                .zip(lit.identity)
                .map(|(a, b)| f64::max(a, b));
            add_areas(&mut hash, &lit.areas);
            visit(i, &lit.areas);
        }
        stated.keep_listed();
        stated.hash = hash.finish();
        stated
    }

    /// Returns the lit areas towards a sun, with at most a number of facets' centres in a tile.
    pub(crate) fn lit_areas_towards(&self, sun: DVec3, tile: u32) -> LitAreas {
        let frame = frame_towards(sun);
        let margin = self.margin_m();
        // Sum the moments of lit parts in the place of centroids, which saves memory.
        let mut areas = vec![LitArea::default(); self.count()];
        let mut undecided = Vec::new();
        let mut silhouette = 0.0;
        self.visit_tiles(&frame, tile, |scene| {
            let parts =
                scene.map_cells(|search: &mut Search, cell| search.lit_parts(scene, cell, margin));
            for part in parts.iter().flatten() {
                areas[part.row as usize].centroid += part.moments;
                undecided.extend(part.has_coplanar.then_some(part.row));
            }
            if self.options().certify {
                let areas = polygons::silhouette_areas(scene);
                silhouette = areas.iter().fold(silhouette, |a, b| a + b);
            }
        });
        let edge_on: Vec<u32> = areas
            .par_iter_mut()
            .zip(0..self.count() as u32)
            .filter_map(|(area, row)| {
                let seen = self.seen(row, &frame);
                *area = self.lit_area_of(row, &frame, seen.as_ref(), area.centroid);
                (seen.is_none() && self.is_edge_on(row, &frame)).then_some(row)
            })
            .collect();
        // A facet may have been computed in several cells.
        undecided.extend(edge_on);
        undecided.sort_unstable();
        undecided.dedup();
        LitAreas {
            identity: self.options().certify.then(|| {
                let lit: f64 = areas.iter().map(|facet| facet.projected).sum();
                (lit - silhouette).abs() / silhouette.max(f64::MIN_POSITIVE)
            }),
            undecided,
            areas,
        }
    }

    /// Passes all tiles towards a sun to `visit`, one after another.
    fn visit_tiles(&self, frame: &DMat3, tile: u32, mut visit: impl FnMut(&Scene)) {
        let rows = self.count() as u32;
        let seen = |row| self.seen(row, frame);
        let grid = Grid::new(
            bounds_across(frame, self.bounds),
            rows,
            tile as usize,
            &seen,
        );
        for tile in grid.tiles() {
            visit(&Scene::new(&grid, tile, rows, &seen));
        }
    }

    /// Returns a facet as the sun sees it; `None` if it doesn't, and the facet casts no shadow.
    fn seen(&self, row: u32, frame: &DMat3) -> Option<Projected> {
        let [a, b, c] = self
            .local_corners(row)
            .map(|corner| frame.transpose_mul_vec3(corner));
        let twice_area = (b - a).xy().perp_dot((c - a).xy());
        let corners = match self.options().sides {
            _ if twice_area.abs() <= self.least_twice_area(a, b, c) => return None,
            _ if twice_area > 0.0 => [a, b, c],
            Sides::Both => [a, c, b],
            Sides::Front => return None,
        };
        Some(Projected { corners })
    }

    /// Returns twice the area across the light below which a facet is edge-on: as wide as the
    /// margin at most.
    fn least_twice_area(&self, a: DVec3, b: DVec3, c: DVec3) -> f64 {
        let longest = (b - a).abs().max((c - a).abs()).max((c - b).abs());
        self.margin_m() * longest.truncate().max_element()
    }

    /// Returns whether a facet has an area, but not as the sun sees it.
    fn is_edge_on(&self, row: u32, frame: &DMat3) -> bool {
        let [a, b, c] = self.local_corners(row);
        let twice_area = (b - a).cross(c - a).length();
        let longest = (b - a).abs().max((c - a).abs()).max((c - b).abs());
        let [p, q, r] = [a, b, c].map(|corner| frame.transpose_mul_vec3(corner));
        twice_area > self.margin_m() * longest.max_element()
            && (q - p).xy().perp_dot((r - p).xy()).abs() <= self.least_twice_area(p, q, r)
    }

    pub(crate) fn centre(&self, row: usize) -> DVec3 {
        let [a, b, c] = self.local_corners(row as u32);
        self.to_world((a + b + c) / 3.0)
    }

    /// Returns the lit area of a row, given the moments of its lit part across the light.
    fn lit_area_of(
        &self,
        row: u32,
        frame: &DMat3,
        seen: Option<&Projected>,
        moments: DVec3,
    ) -> LitArea {
        let unlit = LitArea {
            centroid: self.centre(row as usize),
            ..LitArea::default()
        };
        let Some(facet) = seen else {
            return unlit;
        };
        let [a, b, c] = facet.corners;
        let [p, q] = [b - a, c - a];
        let twice_area = p.xy().perp_dot(q.xy());
        let lit = moments.z.clamp(0.0, twice_area);
        if lit == 0.0 {
            return unlit;
        }
        let fraction = lit / twice_area;
        // Weights of the corners b and c at the centre across the light are the same in space.
        let centre = moments.xy() / (3.0 * moments.z);
        let weight_b = centre.perp_dot(q.xy()) / twice_area;
        let weight_c = p.xy().perp_dot(centre) / twice_area;
        LitArea {
            fraction,
            area: fraction * self.area_m2(row as usize),
            projected: 0.5 * lit,
            centroid: self.to_world(frame * (a + p * weight_b + q * weight_c)),
        }
    }
}

/// Adds the numbers of lit areas to a hash.
pub(crate) fn add_areas(hash: &mut AnswerHash, areas: &[LitArea]) {
    for facet in areas {
        hash.add(facet.fraction);
        hash.add(facet.area);
        hash.add(facet.projected);
        for coordinate in facet.centroid.to_array() {
            hash.add(coordinate);
        }
    }
}

/// The lit areas towards one sun.
#[derive(Debug, PartialEq)]
pub(crate) struct LitAreas {
    pub(crate) areas: Vec<LitArea>,
    pub(crate) undecided: Vec<u32>,
    identity: Option<f64>,
}

/// The lit part of a facet across the light, or of its part within a cell.
struct LitPart {
    row: u32,
    has_coplanar: bool,
    /// Moments that [`clip::lit_moments`] returns.
    moments: DVec3,
}

/// Memory of a search, reused from facet to facet.
#[derive(Debug, Default)]
struct Search {
    stack: Stack,
    blockers: Vec<Blocker>,
    /// Dark facets of the cell that need not be blockers of its wide facets. Each was darkened by
    /// facets that were not needless then. Following these leads to facets that never are. They
    /// darken the same, unless the receiver is one of them: then there is a cycle within the margin.
    needless: FacetSet,
    /// True if a needless facet darkened a part of the last one.
    used_needless: bool,
}

impl Search {
    /// Returns the lit parts of the facets that are computed in a cell.
    fn lit_parts(&mut self, scene: &Scene, cell: u32, margin: f64) -> Vec<LitPart> {
        self.needless.clear();
        let rectangle = scene.rectangle(cell);
        let [low, high] = rectangle;
        let centre = low.midpoint(high);
        let mut wide = scene.wide_facets(rectangle, &mut self.stack);
        let mut narrow: Vec<u32> = scene.narrow_facets(cell).collect();
        if wide.is_empty() {
            let lit_part = |search: &mut Self, index| search.lit_part(scene, index, margin, None);
            if narrow.len() <= MOST_IN_SERIES {
                return narrow.into_iter().map(|i| lit_part(self, i)).collect();
            }
            // A cell has many facets if they are as wide as the cell, as these do not divide it.
            // None depends on those before.
            return narrow
                .into_par_iter()
                .map_init(Self::default, lit_part)
                .collect();
        }
        // No needless facet may prove another one. So begin with the lowest narrow ones: those
        // above are not needless yet. Begin with the highest wide ones: lower ones skip them.
        sort_by(&mut narrow, |i| scene.facets[i as usize].mean_height());
        sort_by(&mut wide, |i| {
            let facet = &scene.facets[i as usize];
            -facet.height_at(centre - facet.corners[0].xy())
        });
        let mut parts = Vec::with_capacity(narrow.len() + wide.len());
        for &index in &narrow {
            let part = self.lit_part(scene, index, margin, None);
            self.add_if_needless(index, &part);
            parts.push(part);
        }
        for &index in &wide {
            let part = self.lit_part(scene, index, margin, Some(rectangle));
            self.add_if_needless(index, &part);
            parts.push(part);
        }
        parts
    }

    /// Adds the last facet to the needless ones if others darken it, or it has no part in the cell.
    /// Those that overlap another one in the same plane stay: offsets within the margin add up.
    fn add_if_needless(&mut self, index: u32, part: &LitPart) {
        if part.moments.z == 0.0 && !part.has_coplanar && !self.used_needless {
            self.needless.insert(index);
        }
    }

    /// Returns the lit part of a facet, within a cell if one is given.
    fn lit_part(
        &mut self,
        scene: &Scene,
        index: u32,
        margin: f64,
        cell: Option<Rectangle>,
    ) -> LitPart {
        let facet = &scene.facets[index as usize];
        let receiver = Receiver::new(facet, scene.row(index), margin);
        let whole = receiver.corners;
        self.used_needless = false;
        let moments = match cell {
            None => self.lit_moments(scene, index, &receiver, &whole, MAX_HALVINGS),
            Some(cell) => {
                let part = receiver.part_within(cell);
                self.lit_moments(scene, index, &receiver, &part, MAX_HALVINGS)
            }
        };
        LitPart {
            row: scene.row(index),
            has_coplanar: receiver.has_coplanar.get(),
            moments,
        }
    }

    /// Returns the moments of the lit part of a convex polygon on a facet, which is halved up to
    /// `halvings` times.
    fn lit_moments(
        &mut self,
        scene: &Scene,
        index: u32,
        receiver: &Receiver<'_>,
        polygon: &[DVec2],
        halvings: u32,
    ) -> DVec3 {
        if polygon.len() < 3 {
            return DVec3::ZERO;
        }
        let most = if halvings > 0 {
            MOST_BLOCKERS
        } else {
            usize::MAX
        };
        let query = receiver.query_above(polygon);
        let blockers = &mut self.blockers;
        blockers.clear();
        // The search ends at the first caster that darkens all. Wide ones are first.
        let is_narrow = scene.is_narrow(index);
        let mut is_dark = false;
        let mut uses_needless = false;
        let is_ended = scene.visit_overlapping(&query, &mut self.stack, |candidate| {
            if candidate == index {
                return false;
            }
            // A needless facet is no blocker of a wide one. Needless wide candidates are tested all
            // the same, since one may darken all.
            let is_needless = self.needless.has(candidate);
            if is_needless && !is_narrow && scene.is_narrow(candidate) {
                return false;
            }
            let caster = &scene.facets[candidate as usize];
            let blocker = receiver.blocker(caster, scene.row(candidate));
            let Some(part) = blocker.and_then(|blocker| blocker.within(polygon)) else {
                return false;
            };
            is_dark = part.covers_all();
            if is_dark {
                uses_needless = is_needless;
            } else if is_narrow || !is_needless {
                uses_needless |= is_needless;
                blockers.push(part);
            }
            is_dark || blockers.len() > most
        });
        if is_dark {
            self.used_needless |= uses_needless;
            return DVec3::ZERO;
        }
        if !is_ended {
            self.used_needless |= uses_needless;
            return clip::lit_moments(polygon, blockers, MAX_HALVINGS);
        }
        // Search again for each half, which is more probably dark by one caster.
        let [first, second] = clip::halve(polygon);
        let mut lit_half =
            |half: &[DVec2]| self.lit_moments(scene, index, receiver, half, halvings - 1);
        lit_half(&first) + lit_half(&second)
    }
}

/// A set of facets.
#[derive(Debug, Default)]
struct FacetSet {
    /// A bit for each facet, up to the greatest one that was in the set.
    words: Vec<u64>,
    members: Vec<u32>,
}

impl FacetSet {
    fn has(&self, facet: u32) -> bool {
        let word = self.words.get(facet as usize / 64);
        word.is_some_and(|word| word >> (facet % 64) & 1 != 0)
    }

    fn insert(&mut self, facet: u32) {
        let word = facet as usize / 64;
        if word >= self.words.len() {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= 1 << (facet % 64);
        self.members.push(facet);
    }

    fn clear(&mut self) {
        for facet in self.members.drain(..) {
            self.words[facet as usize / 64] = 0;
        }
    }
}

/// Sorts facets by a number, then by index.
fn sort_by(facets: &mut Vec<u32>, number: impl Fn(u32) -> f64) {
    let mut sorted: Vec<(f64, u32)> = facets.iter().map(|&i| (number(i), i)).collect();
    sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    facets.clear();
    facets.extend(sorted.into_iter().map(|(_, index)| index));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, tree::query_all};
    use std::ops::Range;

    /// Returns a pseudorandom vector with coordinates in 0..1.
    fn random(k: i32) -> DVec3 {
        let phases = DVec3::new(12.9, 78.2, 37.7) * f64::from(k);
        (phases.sin() * 43_758.5).fract_gl()
    }

    fn facets_of(corners: &[[DVec3; 3]]) -> Facets {
        let rows = 0..corners.len() as u32;
        let triangles: Vec<[u32; 3]> = rows.map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let options = Options {
            unit_m: Some(1.0),
            certify: true,
            ..Options::default()
        };
        Facets::new(corners.as_flattened(), &triangles, &options).expect("good facets")
    }

    /// Dense heaps of different widths, which make cells of all sizes, among triangles as wide as
    /// those and strips: in one tile and in many.
    #[test]
    fn tiles_leave_all_bits_as_they_are() {
        for seed in 0..4 {
            let random = |k: i32| random(20_000 * seed + k);
            let triangle = |k: i32, position: DVec3, size: DVec3| {
                [1, 2, 3].map(|corner| position + random(k + 6000 * corner) * size)
            };
            let in_heap = |k: i32| {
                let [position, shape] = [k % 4, k % 4 + 4].map(random);
                let width = (-2.0 - 4.0 * shape.x).exp2();
                triangle(k, position + random(k) * width, DVec3::splat(0.05 * width))
            };
            let in_between = |k: i32| {
                let size = (-1.0 - 5.0 * random(k + 300).x).exp2();
                let [wide, strip] = [DVec3::ONE, DVec3::new(0.02, 1.0, 1.0)];
                let shape = [wide, strip, strip.yxz()][k as usize % 3];
                triangle(k, random(k), size * shape)
            };
            let heaps = (10..5210).map(in_heap);
            let facets = facets_of(
                &heaps
                    .chain((5400..5700).map(in_between))
                    .collect::<Vec<_>>(),
            );
            for sun in [DVec3::Z, DVec3::new(0.6, -0.64, 0.48)] {
                let frame = frame_towards(sun);
                let mut tiles = 0;
                facets.visit_tiles(&frame, 300, |_| tiles += 1);
                assert!(tiles > 6, "{tiles} tiles");
                let tiled = facets.lit_areas_towards(sun, 300);
                assert!(
                    tiled == facets.lit_areas_towards(sun, TILE),
                    "seed {seed}, towards {sun}"
                );
                let identity = tiled.identity.expect("certified");
                assert!(identity < 1e-9, "{identity:.1e} towards {sun}");
            }
        }
    }

    /// A dense heap on wide ground of a few squares: cells are small around the heap, and facets that
    /// overlap many cells are computed cell by cell.
    #[test]
    fn cells_are_small_where_facets_are() {
        let square = |i: i32| {
            let corner = DVec3::new(f64::from(i % 7), f64::from(i / 7), 0.0) * 100.0;
            let [x, y] = [DVec3::X, DVec3::Y].map(|axis| corner + axis * 100.0);
            let opposite = x + y - corner;
            [[corner, x, opposite], [corner, opposite, y]]
        };
        let small = |i: i32| {
            let position = random(i) + DVec3::new(399.0, 301.0, 0.1);
            [1, 2, 3].map(|k| position + random(5000 * k + i) * 0.01)
        };
        let mut corners: Vec<_> = (0..49).flat_map(square).collect();
        corners.extend((0..5000).map(small));
        let facets = facets_of(&corners);
        for sun in [DVec3::Z, DVec3::new(0.6, -0.64, 0.48)] {
            facets.visit_tiles(&frame_towards(sun), TILE, |scene| {
                let mut cells_of_narrow = vec![0; scene.facets.len()];
                let cells = scene.map_cells(|stack: &mut Stack, cell| {
                    let query = query_all(scene.rectangle(cell).map(|p| p.extend(0.0)));
                    let mut overlapping = Vec::new();
                    scene.visit_overlapping(&query, stack, |index| {
                        overlapping.extend(scene.is_narrow(index).then_some(index));
                        false
                    });
                    (scene.narrow_facets(cell).count(), overlapping)
                });
                for (computed, overlapping) in cells {
                    // Facets as wide as their cell do not count; here they are few.
                    assert!(computed <= 1024, "{computed} facets in a cell");
                    overlapping
                        .iter()
                        .for_each(|&i| cells_of_narrow[i as usize] += 1);
                }
                let most = cells_of_narrow.iter().max();
                assert!(most <= Some(&4), "{most:?} cells, but computed in one");
            });
            // Tiles of ground do not contain the heap, though a square of ground reaches that far.
            let mut in_tiles = 0;
            facets.visit_tiles(&frame_towards(sun), 300, |scene| {
                in_tiles += scene.facets.len();
            });
            assert!(in_tiles < 2 * facets.count(), "{in_tiles} facets in tiles");
            let lit = facets.lit_areas_towards(sun, 300);
            assert!(lit == facets.lit_areas_towards(sun, TILE), "towards {sun}");
            let identity = lit.identity.expect("certified");
            assert!(identity < 1e-9, "{identity:.1e} towards {sun}");
        }
    }

    /// Facets that end within the tree's rounding of a tile's border are in its tree, as they are if
    /// there is one tile: they cut the parts of others that they touch.
    #[test]
    fn facets_near_the_border_of_a_tile_are_in_it() {
        let frame = frame_towards(DVec3::Z);
        let mut corners = Vec::new();
        let mut push = |triangle: [[f64; 3]; 3]| {
            corners.push(triangle.map(|corner| frame * DVec3::from(corner)));
        };
        // A floor, and dense facets in two quarters of it: the other two quarters are cells.
        push([[0.0; 3], [4.0, 3.37, 0.3], [0.21, 4.0, 0.7]]);
        for (corner, count) in [(DVec3::splat(0.5), 1100), (DVec3::splat(2.5), 400)] {
            for i in 0..count {
                let position = corner + random(i);
                push([1, 2, 3].map(|k| (position + random(5000 * k + i) * 0.01).to_array()));
            }
        }
        // Facets that point at the border of the upper left quarter.
        for i in 0..40 {
            let y = 2.1 + 0.04 * f64::from(i);
            push([
                [2.0 + 1e-7, y, 1.0],
                [3.9, y - 0.01, 1.0],
                [3.9, y + 0.013, 1.0],
            ]);
        }
        let facets = facets_of(&corners);
        let mut tiles = 0;
        facets.visit_tiles(&frame, 300, |_| tiles += 1);
        assert!(tiles > 2, "{tiles} tiles");
        let lit = facets.lit_areas_towards(DVec3::Z, 300);
        assert!(lit == facets.lit_areas_towards(DVec3::Z, TILE));
    }

    /// A strip over the end of a facet that extends beyond its cell, almost as far as it can. The
    /// strip's corners are in small cells of heaps; its middle is not.
    #[test]
    fn strips_between_small_cells_cast_shadows() {
        let frame = frame_towards(DVec3::Z);
        let mut corners = vec![
            [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0]],
            [[1.01, 1.495, 1.0], [1.99, 1.5, 1.0], [1.5, 2.485, 1.0]],
            [[0.1, 2.46, 2.0], [3.9, 2.47, 2.0], [0.1, 2.48, 2.0]],
        ];
        for (heap, x) in [0.05, 3.85].into_iter().enumerate() {
            let in_heap = |i: i32| {
                let position = DVec3::new(x, 2.42, 3.0) + random(i) * 0.1;
                [1, 2, 3].map(|k| (position + random(5000 * k + i) * 0.001).to_array())
            };
            corners.extend((0..1100).map(|i| in_heap(1100 * heap as i32 + i)));
        }
        let corners: Vec<_> = corners
            .iter()
            .map(|triangle| triangle.map(|corner| frame * DVec3::from(corner)))
            .collect();
        let facets = facets_of(&corners);
        facets.visit_tiles(&frame, TILE, |scene| {
            // The first three rows are wide but for the facet.
            let wide = (0..scene.facets.len() as u32).filter(|&index| !scene.is_narrow(index));
            let rows: Vec<u32> = wide.map(|index| scene.row(index)).collect();
            assert!(rows.contains(&0) && rows.contains(&2) && !rows.contains(&1));
        });
        let lit = facets.lit_areas_towards(DVec3::Z, 300);
        assert!(lit == facets.lit_areas_towards(DVec3::Z, TILE));
        assert!(lit.areas[1].fraction < 1.0, "{}", lit.areas[1].fraction);
    }

    /// Returns a floor of two wide triangles, narrow ones that may be above it, and small ones below
    /// it, which make cells.
    fn floor_below(narrow: &[[DVec3; 3]]) -> Facets {
        let [a, b, c] = [DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|corner| 4.0 * corner);
        let mut corners = vec![[DVec3::ZERO, a, b], [DVec3::ZERO, b, c]];
        corners.extend(narrow);
        let small = |i: i32| {
            let position = random(i) * 4.0 - DVec3::Z * 5.0;
            [1, 2, 3].map(|k| position + random(5000 * k + i) * 0.02)
        };
        corners.extend((0..1100).map(small));
        let facets = facets_of(&corners);
        facets.visit_tiles(&frame_towards(DVec3::Z), TILE, |scene| {
            for index in 0..scene.facets.len() as u32 {
                assert_eq!(scene.is_narrow(index), scene.row(index) > 1);
            }
        });
        facets
    }

    /// Returns the area of some rows that is lit from above.
    fn lit_rows(facets: &Facets, rows: Range<usize>) -> f64 {
        let lit = facets.lit_areas_towards(DVec3::Z, TILE);
        lit.areas[rows].iter().map(|facet| facet.area).sum()
    }

    /// Three facets that darken each other in a cycle, none in the plane of another. One of them may
    /// be cut in two. All are dark, and the floor must be dark below them nevertheless.
    #[test]
    fn facets_in_a_cycle_cast_shadows() {
        let base = [[0.25, 0.25], [0.625, 0.375], [0.375, 0.75]];
        let cycle = |margin: f64| {
            let offsets = [[0.0; 3], [0.9, 0.9, -1.1], [1.8, -0.95, -0.2]];
            offsets.map(|offsets| {
                [0, 1, 2].map(|i| DVec3::new(base[i][0], base[i][1], 1.0 + margin * offsets[i]))
            })
        };
        let margin = floor_below(&cycle(0.0)).margin_m();
        let [a, b, c] = cycle(margin);
        let middle = a[2] + (a[1] - a[2]) / 32.0;
        let halves = [[a[0], a[1], middle], [a[0], middle, a[2]]];
        let dark = 0.5 * (a[1] - a[0]).cross(a[2] - a[0]).z;
        for cycle in [vec![a, b, c], vec![halves[0], halves[1], b, c]] {
            let facets = floor_below(&cycle);
            assert_eq!(lit_rows(&facets, 2..2 + cycle.len()), 0.0, "no cycle");
            let lit = lit_rows(&facets, 0..2);
            assert!((lit - (16.0 - dark)).abs() < 1e-12, "{lit}");
        }
    }

    /// Triangles that are repeated within some margins cast the shadows of single ones.
    #[test]
    fn near_duplicates_cast_shadows() {
        let once = |i: i32| {
            let position = random(i) * DVec3::new(3.5, 3.5, 0.0) + DVec3::Z;
            [1, 2, 3].map(|k| position + random(5000 * k + i) * 0.4)
        };
        let single: Vec<_> = (0..100).map(once).collect();
        let repeated: Vec<_> = (0..500)
            .map(|i| once(i % 100).map(|corner| corner + random(i + 900) * 1e-11))
            .collect();
        let [expected, lit] =
            [single, repeated].map(|narrow| lit_rows(&floor_below(&narrow), 0..2));
        assert!(expected < 15.5, "{expected}");
        assert!((lit - expected).abs() < 1e-9, "{lit} for {expected}");
    }
}
