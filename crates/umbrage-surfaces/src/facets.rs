//! The list of facets.

use crate::{FacetsError, Options, Sides};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::{ops::Range, sync::OnceLock};
use umbrage_core::{Anchor, Geometry, Instance, Mesh, Scene};

/// Rows that errors name.
const NAMED: usize = 8;

/// Triangles in 64-bit coordinates, prepared for questions about sunlight.
///
/// Rows are the caller's: facet `i` is `triangles[i]`. Facets without an area are allowed; they
/// cast nothing and have no lit area.
#[derive(Clone, Debug)]
pub struct Facets {
    /// Metres, relative to the anchor.
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    options: Options,
    /// The point that positions are relative to, metres.
    pub(crate) anchor: DVec3,
    /// Greatest coordinate of the caller's, metres.
    world_reach: f64,
    /// Greatest coordinate relative to the anchor, metres.
    local_reach: f64,
    /// Box around the facets, relative to the anchor, metres.
    pub(crate) bounds: [DVec3; 2],
    /// For rays, built on first use.
    geometry: OnceLock<Geometry>,
}

impl Facets {
    /// Returns the facets with these corners. `vertices` are in the caller's axes and unit, in any
    /// distance from the origin; differences are computed in 64 bits.
    ///
    /// # Errors
    /// Errors if there is no triangle, if a number is not finite or an index out of range, if
    /// coordinates are too large for [`Options::max_error_m`], if the unit is not stated and the
    /// length is improbable in metres, or if a mesh with [`Sides::Front`] is not closed or faces
    /// inwards. Errors name the rows.
    pub fn new(
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        options: &Options,
    ) -> Result<Self, FacetsError> {
        check_lists(vertices, triangles)?;
        let unit = options.unit_m.unwrap_or(1.0);
        check_positive("unit, metres", unit)?;
        check_positive("max_error_m", options.max_error_m)?;
        let used = || {
            triangles
                .par_iter()
                .flatten()
                .map(|&v| vertices[v as usize] * unit)
        };
        let low = used().reduce(|| DVec3::INFINITY, DVec3::min);
        let high = used().reduce(|| DVec3::NEG_INFINITY, DVec3::max);
        let world_reach = low.abs().max(high.abs()).max_element();
        let anchor = Anchor::nearest_to(low.midpoint(high))
            .unwrap_or(Anchor::ORIGIN)
            .point();
        let bounds = [low - anchor, high - anchor];
        let mut facets = Self {
            vertices: Vec::new(),
            triangles: triangles.to_vec(),
            options: *options,
            anchor,
            world_reach,
            local_reach: bounds[0].abs().max(bounds[1].abs()).max_element(),
            bounds,
            geometry: OnceLock::new(),
        };
        facets.check_reach(&[])?;
        if options.unit_m.is_none() {
            check_metres((high - low).max_element())?;
        }
        facets.vertices = vertices.par_iter().map(|&v| facets.to_local(v)).collect();
        if options.sides == Sides::Front {
            facets.check_closed()?;
        }
        Ok(facets)
    }

    /// Returns the number of facets, at least one.
    pub fn count(&self) -> usize {
        self.triangles.len()
    }

    /// Returns the settings.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Returns the corners of a facet, in the caller's axes, metres.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn corners_m(&self, row: usize) -> [DVec3; 3] {
        self.local_corners(row as u32)
            .map(|corner| corner + self.anchor)
    }

    /// Returns the area of a facet, square metres.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn area_m2(&self, row: usize) -> f64 {
        let [a, b, c] = self.local_corners(row as u32);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Returns the unit normal of a facet, from which its corners are counter-clockwise; zero if it
    /// has no area.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn normal(&self, row: usize) -> DVec3 {
        let [a, b, c] = self.local_corners(row as u32);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Returns the margin of answers, metres: the rounding of the caller's coordinates, and of
    /// computations with those relative to the facets' middle.
    pub fn margin_m(&self) -> f64 {
        self.margin_within(self.local_reach)
    }

    /// Returns the margin for coordinates that reach this far from the anchor, metres.
    pub(crate) fn margin_within(&self, reach: f64) -> f64 {
        // One rounding is half an epsilon. The factors are sums of the roundings of a plane through
        // three corners, evaluated at a fourth, with slack for thin facets.
        let given = 16.0 * f64::EPSILON * self.world_reach;
        let computed = 512.0 * f64::EPSILON * reach.max(self.local_reach);
        given + computed
    }

    /// Returns an error if the facets or these points exceed the greatest accepted margin.
    pub(crate) fn check_reach(&self, points: &[DVec3]) -> Result<(), FacetsError> {
        let reach = reach_of(points).max(self.local_reach);
        let loses_m = self.margin_within(reach);
        if loses_m <= self.options.max_error_m {
            return Ok(());
        }
        let reach_m = reach.max(self.world_reach);
        let why = format!("reach {reach_m:.3e} m, where answers are uncertain by {loses_m:.1e} m");
        let help = "move the origin nearer, check the unit, or raise `max_error_m`";
        Err(FacetsError::new("coordinates", why, help))
    }

    /// Returns a position of the caller's relative to the anchor, metres.
    pub(crate) fn to_local(&self, position: DVec3) -> DVec3 {
        position * self.options.unit_m.unwrap_or(1.0) - self.anchor
    }

    /// Returns a position relative to the anchor in the caller's axes, metres.
    pub(crate) fn to_world(&self, local: DVec3) -> DVec3 {
        local + self.anchor
    }

    /// Returns the corners of a facet, relative to the anchor.
    pub(crate) fn local_corners(&self, row: u32) -> [DVec3; 3] {
        self.triangles[row as usize].map(|v| self.vertices[v as usize])
    }

    /// Returns the facets in 32 bits, whose hierarchy preselects casters for rays.
    pub(crate) fn geometry(&self) -> &Geometry {
        self.geometry.get_or_init(|| {
            let positions: Vec<Vec3> = self.vertices.iter().map(|v| v.as_vec3()).collect();
            let mut scene = Scene::default();
            scene.meshes.push(Mesh {
                positions,
                triangles: self.triangles.clone(),
                ..Mesh::default()
            });
            scene
                .instances
                .push(Instance::new(0, glam::Affine3A::IDENTITY));
            // Coordinates are finite in 32 bits, as their margin has been checked.
            Geometry::bake(&scene).unwrap_or_default()
        })
    }

    /// Returns the first facet along a ray, computed in 32 bits: for images. Both sides count. The
    /// ray begins at a position in the caller's axes, metres, and ends after a step. `None` if it
    /// meets no facet.
    pub fn first_along(&self, start_m: DVec3, step_m: DVec3) -> Option<usize> {
        let geometry = self.geometry();
        let start = (start_m - self.anchor).as_vec3();
        let none = u32::MAX;
        let bvh = geometry.bvh();
        let hit = bvh.nearest_triangle(geometry, start, step_m.as_vec3(), none);
        hit.map(|(_, row)| row as usize)
    }

    /// Returns an error unless each edge has neighbours in both directions, and each connected body
    /// has a positive volume.
    fn check_closed(&self) -> Result<(), FacetsError> {
        let welded = self.welded_vertices();
        let mut open = Vec::new();
        // Edges of some vertices at once, which bounds the memory.
        for first in (0..welded.len() as u32).step_by(1 << 20) {
            open.extend(self.open_edges(&welded, first..first.saturating_add(1 << 20)));
        }
        if open.is_empty() {
            return self.check_outward(&welded);
        }
        let rows = &open[..open.len().min(NAMED)];
        let why = format!(
            "{} edges, such as those of facets {rows:?}, have no neighbour that is turned alike",
            open.len()
        );
        let help = "close the mesh, or use both sides";
        Err(FacetsError::new("front sides", why, help))
    }

    /// Returns a facet of each edge without a neighbour, among edges whose lower vertex is in a
    /// range.
    fn open_edges(&self, welded: &[u32], range: Range<u32>) -> Vec<u32> {
        // Each edge from its lower vertex, with its facet and whether it is turned round.
        let mut edges: Vec<([u32; 2], u32, bool)> = (0..self.count() as u32)
            .into_par_iter()
            .flat_map_iter(|row| {
                let [a, b, c] = self.triangles[row as usize].map(|v| welded[v as usize]);
                // Facets with equal corners have no area and close nothing.
                let is_flat = a == b || b == c || c == a;
                let sides = [[a, b], [b, c], [c, a]].into_iter();
                let sides = sides.filter(move |_| !is_flat);
                sides.map(move |[from, to]| ([from.min(to), from.max(to)], row, from > to))
            })
            .filter(|(edge, ..)| range.contains(&edge[0]))
            .collect();
        edges.par_sort_unstable();
        let groups = edges.chunk_by(|a, b| a.0 == b.0);
        let is_open = |same: &&[([u32; 2], u32, bool)]| {
            let turned = same.iter().filter(|edge| edge.2).count();
            2 * turned != same.len()
        };
        groups.filter(is_open).map(|same| same[0].1).collect()
    }

    /// Returns an error if a connected body has a negative volume.
    fn check_outward(&self, welded: &[u32]) -> Result<(), FacetsError> {
        // Union-find over welded vertices, with path halving.
        let mut parents: Vec<u32> = (0..welded.len() as u32).collect();
        let root = |parents: &mut Vec<u32>, mut v: u32| {
            while parents[v as usize] != v {
                parents[v as usize] = parents[parents[v as usize] as usize];
                v = parents[v as usize];
            }
            v
        };
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| root(&mut parents, welded[v as usize]));
            let least = a.min(b).min(c);
            for v in [a, b, c] {
                parents[v as usize] = least;
            }
        }
        let mut volumes = vec![0.0; welded.len()];
        let bodies: Vec<u32> = self
            .triangles
            .iter()
            .map(|triangle| root(&mut parents, welded[triangle[0] as usize]))
            .collect();
        for (row, &body) in bodies.iter().enumerate() {
            // Six times the volume of the tetrahedron to a vertex of the body.
            let origin = self.vertices[body as usize];
            let [a, b, c] = self.local_corners(row as u32).map(|corner| corner - origin);
            volumes[body as usize] += a.dot(b.cross(c));
        }
        let inverted = || (0..self.count()).filter(|&row| volumes[bodies[row] as usize] < 0.0);
        let facets = inverted().count();
        if facets == 0 {
            return Ok(());
        }
        let rows: Vec<usize> = inverted().take(NAMED).collect();
        let why = format!("{facets} facets, such as {rows:?}, are of bodies that face inwards");
        let help = "swap two corners of each of these facets, or use both sides";
        Err(FacetsError::new("front sides", why, help))
    }

    /// Returns, for each vertex, the first one at the same position.
    fn welded_vertices(&self) -> Vec<u32> {
        // The sum makes the negative zero positive.
        let key = |v: u32| {
            (self.vertices[v as usize] + 0.0)
                .to_array()
                .map(f64::to_bits)
        };
        let mut sorted: Vec<u32> = (0..self.vertices.len() as u32).collect();
        sorted.par_sort_unstable_by_key(|&v| (key(v), v));
        let mut welded = vec![0; sorted.len()];
        for same in sorted.chunk_by(|&a, &b| key(a) == key(b)) {
            for &v in same {
                welded[v as usize] = same[0];
            }
        }
        welded
    }
}

/// Returns the greatest coordinate.
pub(crate) fn reach_of(points: &[DVec3]) -> f64 {
    points
        .iter()
        .fold(0.0, |reach, p| p.abs().max_element().max(reach))
}

/// Returns an error unless a setting is finite and greater than zero.
pub(crate) fn check_positive(what: &str, value: f64) -> Result<(), FacetsError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let help = "use a finite number greater than zero";
    Err(FacetsError::new(what, format!("is {value}"), help))
}

/// Returns an error with the first vector that is not finite.
pub(crate) fn check_finite(what: &str, vectors: &[DVec3]) -> Result<(), FacetsError> {
    match vectors.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(row) => {
            let why = format!("is {}", vectors[row]);
            Err(FacetsError::new(
                format!("{what} {row}"),
                why,
                "use finite numbers",
            ))
        }
    }
}

fn check_lists(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), FacetsError> {
    let most = i32::MAX as usize;
    if triangles.is_empty() || triangles.len() > most || vertices.len() > most {
        let why = format!(
            "are {} triangles of {} vertices",
            triangles.len(),
            vertices.len()
        );
        return Err(FacetsError::new(
            "facets",
            why,
            "use at least one and at most 2^31 - 1",
        ));
    }
    check_finite("vertex", vertices)?;
    let count = vertices.len();
    let is_faulty = |triangle: &[u32; 3]| triangle.iter().any(|&v| v as usize >= count);
    let Some(row) = triangles.iter().position(is_faulty) else {
        return Ok(());
    };
    let why = format!("has the corners {:?} of {count} vertices", triangles[row]);
    let help = format!("use indices from 0 to {}", count.saturating_sub(1));
    Err(FacetsError::new(format!("facet {row}"), why, help))
}

/// Returns an error that names a suspect if the length of the facets is improbable in metres.
fn check_metres(extent_m: f64) -> Result<(), FacetsError> {
    let suspect = match extent_m {
        ..0.1 => "kilometres",
        0.1..2e3 => return Ok(()),
        2e3..2e4 => "centimetres",
        _ => "millimetres",
    };
    let why = format!("are {extent_m} m long: {suspect}?");
    Err(FacetsError::new(
        "facets",
        why,
        "state the unit, also if it is metres",
    ))
}
