//! The lit areas of facets.

use crate::{
    Facets, Sides, Stated, Suns,
    clip::{self, Receiver},
    frame::{Frame, cross},
    outline,
    stated::AnswerHash,
    tree::{self, Scene, bounds_across},
};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;

/// Facets per task.
const TASK: usize = 256;
/// Candidates above which a receiver is halved.
const TILED: usize = 256;
/// The largest candidates, which may darken all of a tile.
const LARGEST: usize = 4;
/// Candidates from which halves are computed on several threads.
const CASTERS_FOR_THREADS: usize = 1024;
/// Mark of rows that the sun doesn't see.
const UNSEEN: u32 = u32::MAX;

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
    /// Undecided are facets that are edge-on to the sun within the margin, and those that overlap
    /// another one in the same plane.
    pub fn lit_area(&self, suns: &Suns, mut visit: impl FnMut(usize, &[LitArea])) -> Stated {
        let mut stated = Stated {
            margin_m: self.margin_m(),
            identity: self.options().certify.then_some(0.0),
            ..Stated::default()
        };
        let mut hash = AnswerHash::new();
        for (i, &sun) in suns.directions().iter().enumerate() {
            let lit = self.lit_areas_towards(sun);
            stated.add_undecided(i, lit.undecided);
            stated.identity = stated
                .identity
                .zip(lit.identity)
                .map(|(a, b)| f64::max(a, b));
            add_areas(&mut hash, &lit.areas);
            visit(i, &lit.areas);
        }
        stated.hash = hash.finish();
        stated
    }

    /// Returns the area of the facets' silhouette towards each sun, square metres. It is computed
    /// from the outlines, independently of lit areas.
    pub fn silhouette_areas(&self, suns: &Suns) -> Vec<f64> {
        let area =
            |&sun| outline::union_area(&self.scene_towards(&Frame::new(sun)), self.margin_m());
        suns.directions().iter().map(area).collect()
    }

    pub(crate) fn lit_areas_towards(&self, sun: DVec3) -> LitAreas {
        let frame = Frame::new(sun);
        let scene = self.scene_towards(&frame);
        let margin = self.margin_m();
        let mut parts = vec![LitPart::default(); scene.facets.len()];
        parts.par_chunks_mut(TASK).enumerate().for_each_init(
            Search::default,
            |search, (task, parts)| {
                for (i, part) in parts.iter_mut().enumerate() {
                    *part = search.lit_part(&scene, task * TASK + i, margin);
                }
            },
        );
        let certify = self.options().certify;
        let silhouette = certify.then(|| outline::union_area(&scene, margin));
        let mut place = vec![UNSEEN; self.len()];
        for (i, &row) in scene.rows.iter().enumerate() {
            place[row as usize] = i as u32;
        }
        // Free the largest memory before the answer needs its own.
        drop(scene);
        let part_of = |row: u32| parts.get(place[row as usize] as usize);
        let rows = (0..self.len() as u32).into_par_iter();
        let area_of = |row| self.lit_area_of(row, &frame, part_of(row));
        let areas: Vec<LitArea> = rows.clone().map(area_of).collect();
        let is_undecided = |&row: &u32| match part_of(row) {
            Some(part) => part.has_coplanar,
            None => self.is_edge_on(row, &frame),
        };
        LitAreas {
            undecided: rows.filter(is_undecided).collect(),
            identity: silhouette.map(|silhouette| {
                let lit: f64 = areas.iter().map(|facet| facet.projected).sum();
                (lit - silhouette).abs() / silhouette.max(f64::MIN_POSITIVE)
            }),
            areas,
        }
    }

    /// Returns the facets that the sun sees and that cast shadows.
    fn scene_towards(&self, frame: &Frame) -> Scene {
        let bounds = bounds_across(frame, self.bounds());
        let corners = |row| self.corners_towards(row, frame);
        Scene::new(self.len(), corners, bounds)
    }

    /// Returns the corners of a facet in a frame, counter-clockwise as the sun sees them; `None` if
    /// the sun doesn't see it.
    fn corners_towards(&self, row: u32, frame: &Frame) -> Option<[DVec3; 3]> {
        let [a, b, c] = self.local_corners(row).map(|corner| frame.project(corner));
        let twice_area = cross((b - a).xy(), (c - a).xy());
        let is_seen = twice_area.abs() > self.least_twice_area(a, b, c);
        match self.options().sides {
            _ if !is_seen => None,
            Sides::Front => (twice_area > 0.0).then_some([a, b, c]),
            Sides::Both if twice_area > 0.0 => Some([a, b, c]),
            Sides::Both => Some([a, c, b]),
        }
    }

    /// Returns twice the area across the light below which a facet is edge-on: as wide as the
    /// margin at most.
    fn least_twice_area(&self, a: DVec3, b: DVec3, c: DVec3) -> f64 {
        let longest = (b - a).abs().max((c - a).abs()).max((c - b).abs());
        self.margin_m() * longest.truncate().max_element()
    }

    /// Returns whether a facet has an area, but not as the sun sees it.
    fn is_edge_on(&self, row: u32, frame: &Frame) -> bool {
        let [a, b, c] = self.local_corners(row);
        let twice_area = (b - a).cross(c - a).length();
        let longest = (b - a)
            .abs()
            .max((c - a).abs())
            .max((c - b).abs())
            .max_element();
        let [a, b, c] = [a, b, c].map(|corner| frame.project(corner));
        twice_area > self.margin_m() * longest
            && cross((b - a).xy(), (c - a).xy()).abs() <= self.least_twice_area(a, b, c)
    }

    pub(crate) fn centre(&self, row: usize) -> DVec3 {
        let [a, b, c] = self.local_corners(row as u32);
        self.to_world((a + b + c) / 3.0)
    }

    /// Returns the lit area of a row, given its lit part across the light.
    fn lit_area_of(&self, row: u32, frame: &Frame, part: Option<&LitPart>) -> LitArea {
        let unlit = LitArea {
            centroid: self.centre(row as usize),
            ..LitArea::default()
        };
        let Some([a, b, c]) = self.corners_towards(row, frame) else {
            return unlit;
        };
        let [p, q] = [b - a, c - a];
        let twice_area = cross(p.xy(), q.xy());
        let moments = part.map_or(DVec3::ZERO, |part| part.moments);
        let lit = moments.z.clamp(0.0, twice_area);
        if lit == 0.0 {
            return unlit;
        }
        let fraction = lit / twice_area;
        // Weights of the corners b and c at the centre across the light are the same in space.
        let centre = moments.xy() / (3.0 * moments.z);
        let weight_b = cross(centre, q.xy()) / twice_area;
        let weight_c = cross(p.xy(), centre) / twice_area;
        LitArea {
            fraction,
            area: fraction * self.area_m2(row as usize),
            projected: 0.5 * lit,
            centroid: self.to_world(frame.unproject(a + p * weight_b + q * weight_c)),
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
pub(crate) struct LitAreas {
    pub(crate) areas: Vec<LitArea>,
    pub(crate) undecided: Vec<u32>,
    identity: Option<f64>,
}

/// The lit part of a facet across the light.
#[derive(Clone, Copy, Debug, Default)]
struct LitPart {
    /// As of [`clip::moments`].
    moments: DVec3,
    has_coplanar: bool,
}

/// Memory of a search, reused from facet to facet.
#[derive(Debug, Default)]
struct Search {
    stack: Vec<(u32, u32)>,
    candidates: Vec<u32>,
}

impl Search {
    fn lit_part(&mut self, scene: &Scene, index: usize, margin: f64) -> LitPart {
        let facet = &scene.facets[index];
        let receiver = Receiver::new(facet, scene.rows[index], margin);
        self.candidates.clear();
        let query = tree::query_above(&facet.corners, margin);
        scene.overlapping(&query, &mut self.stack, &mut self.candidates);
        self.candidates
            .retain(|&candidate| candidate as usize != index);
        let tile = Tile {
            scene,
            receiver: &receiver,
            margin,
        };
        LitPart {
            moments: tile.lit_moments(&receiver.corners, &self.candidates, clip::MAX_HALVINGS),
            has_coplanar: receiver.has_coplanar.into_inner(),
        }
    }
}

/// A receiver and its casters, of which large receivers are cut into tiles.
struct Tile<'a> {
    scene: &'a Scene,
    receiver: &'a Receiver<'a>,
    margin: f64,
}

impl Tile<'_> {
    /// Returns the moments of the lit part of a convex part of the receiver. Candidates are casters
    /// that may darken it, large ones first. It is halved up to `halvings` times.
    fn lit_moments(&self, polygon: &[DVec2], candidates: &[u32], halvings: u32) -> DVec3 {
        let blocker = |&candidate: &u32| {
            let caster = &self.scene.facets[candidate as usize];
            let row = self.scene.rows[candidate as usize];
            self.receiver.blocker(caster, row)?.within(polygon)
        };
        if candidates.len() > TILED && halvings > 0 {
            let largest = candidates[..LARGEST].iter();
            if largest
                .filter_map(blocker)
                .any(|blocker| blocker.covers_all())
            {
                return DVec3::ZERO;
            }
            let halves = clip::halve(polygon);
            let lists = [0, 1].map(|half| {
                let corners = self.receiver.in_frame(&halves[half]);
                let query = tree::query_above(&corners, self.margin);
                let inside = candidates.iter().copied();
                inside
                    .filter(|&c| self.scene.overlaps(c, &query))
                    .collect::<Vec<u32>>()
            });
            if clip::separates(&lists, candidates.len()) {
                let half = |i: usize| self.lit_moments(&halves[i], &lists[i], halvings - 1);
                if candidates.len() < CASTERS_FOR_THREADS {
                    return half(0) + half(1);
                }
                let (first, second) = rayon::join(|| half(0), || half(1));
                return first + second;
            }
        }
        let mut blockers = Vec::new();
        for blocker in candidates.iter().filter_map(blocker) {
            if blocker.covers_all() {
                return DVec3::ZERO;
            }
            blockers.push(blocker);
        }
        clip::lit_moments(polygon, &blockers, clip::MAX_HALVINGS)
    }
}
