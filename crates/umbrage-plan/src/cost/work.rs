//! Work of a recipe, counted instead of timed, so it is the same on every machine.

use crate::catalogue::Catalogue;
use rayon::prelude::*;
use std::ops::Range;
use umbrage_core::{
    Cast, CastMode, Cull, Geometry, Recipe, Source, View,
    geometry::clip_polygon::Polygon,
    glam::{DMat4, DVec2, DVec4, UVec2},
};

/// Clip-space triangle cut by the six planes of the view volume: at most nine corners.
type ClipPolygon = Polygon<DVec4, 9>;

/// Approximate bytes of a device's hierarchy for each caster, with the buffers that only its passes
/// use, and without the corners.
const HIERARCHY_BYTES: u64 = 84;

/// Work of one execution of a recipe.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
pub struct Work {
    /// Passes: casts, filters, building a hierarchy, and receive.
    pub passes: u64,
    /// Triangles that depth casts draw, including those outside their view; half of them if one
    /// side is culled.
    pub triangles: u64,
    /// Texels that these triangles cover, including overdraw: their area within the view, rounded.
    pub covered: u64,
    /// Covered texels of alpha-tested triangles: each samples an alpha texture.
    #[serde(default)]
    pub cut_out: u64,
    /// Faces that casts of [`CastMode::StencilDepthFail`] draw, including those outside their view.
    #[serde(default)]
    pub faces: u64,
    /// Texels that these faces cover, as in [`covered`](Self::covered): each reads and writes a
    /// count.
    #[serde(default)]
    pub counted: u64,
    /// Triangles that the receive kernel's tables were built from
    /// ([`triangles_listed`](crate::catalogue::CataloguedKernel::triangles_listed)): work of
    /// building the recipe, not of the backend.
    #[serde(default)]
    pub listed: u64,
    /// Texels of the layers that casts draw into.
    pub cleared: u64,
    /// Texels that filters write.
    pub filtered: u64,
    /// Texels that filters load beyond the first for each texel that they write.
    #[serde(default)]
    pub filter_taps: u64,
    /// Pixels that receive shadows.
    pub receivers: u64,
    /// Greatest number of texels loaded by the receive kernel.
    pub taps: u64,
    /// Greatest number of comparison samples of the receive kernel.
    pub samples: u64,
    /// Greatest number of rays traced.
    pub rays: u64,
    /// Casters' triangles that rays are tested against.
    pub casters: u64,
    /// Casters' triangles that the device builds a hierarchy of.
    #[serde(default)]
    pub placed: u64,
    /// Walks through such a hierarchy.
    #[serde(default)]
    pub walks: u64,
    /// Bytes of images and tables.
    pub bytes: u64,
}

impl Work {
    /// Returns the work of a recipe for the view that it was built for. `catalogue` provides the
    /// costs of its kernels. Without receivers in the view, all pixels count as receivers.
    pub fn of_recipe(view: &View<'_>, recipe: &Recipe, catalogue: &Catalogue) -> Self {
        let pixels = u64::from(view.camera.size.x) * u64::from(view.camera.size.y);
        let receivers = view
            .receivers
            .map_or(pixels, |r| r.receives.iter().filter(|&&r| r).count() as u64);
        let kernel = catalogue.kernel(recipe);
        let cost = match view.receivers {
            Some(receivers) => kernel.cost_for(receivers),
            None => kernel.cost_per_receiver(),
        };
        // Count the receive kernel's work.
        let casters = view.geometry.map_or(0, |g| g.casters().len() as u64);
        let hierarchies = usize::from(recipe.hierarchy.is_some());
        let mut work = Self {
            passes: (recipe.casts.len() + recipe.filters.len() + hierarchies + 1) as u64,
            listed: kernel.triangles_listed(),
            receivers,
            taps: receivers * u64::from(cost.taps),
            samples: receivers * u64::from(cost.samples),
            rays: receivers * u64::from(cost.rays),
            casters,
            placed: hierarchies as u64 * casters,
            walks: receivers * u64::from(cost.walks),
            bytes: recipe.image_bytes()
                + recipe.table_bytes()
                + hierarchies as u64 * casters * HIERARCHY_BYTES,
            ..Self::default()
        };
        // Count the drawn triangles and texels.
        for cast in &recipe.casts {
            let size = recipe.images[cast.image].size;
            let Drawn {
                triangles,
                covered,
                cut_out,
            } = drawn_work(view.geometry, cast, size);
            // About half of the faces of closed casters face the light, and a culled face costs
            // almost nothing.
            let sides = if cast.cull == Cull::None { 1 } else { 2 };
            let triangles = triangles / sides;
            match cast.mode {
                CastMode::Depth | CastMode::DepthPeel(_) => {
                    work.triangles += triangles;
                    work.covered += covered;
                    work.cut_out += cut_out;
                }
                CastMode::StencilDepthFail { .. } => {
                    work.faces += triangles;
                    work.counted += covered;
                }
            }
            work.cleared += u64::from(size.x) * u64::from(size.y);
        }
        // Count the filtered texels.
        for filter in &recipe.filters {
            let image = &recipe.images[filter.output];
            let texels = image.texels();
            let more_loads = catalogue.filter_loads(&*filter.kernel).saturating_sub(1);
            work.filtered += texels;
            work.filter_taps += texels * u64::from(more_loads);
        }
        work
    }
}

impl Work {
    /// Returns the work of the lookup only.
    #[must_use]
    pub fn lookup(&self) -> Self {
        Self {
            passes: 1,
            triangles: 0,
            covered: 0,
            cut_out: 0,
            listed: 0,
            placed: 0,
            faces: 0,
            counted: 0,
            cleared: 0,
            filtered: 0,
            filter_taps: 0,
            ..*self
        }
    }

    /// Returns the work of backends, without the work of building the recipe.
    #[must_use]
    pub fn without_lists(&self) -> Self {
        Self { listed: 0, ..*self }
    }

    /// Returns the work of casts and filters only.
    #[must_use]
    pub fn drawing_only(&self) -> Self {
        Self {
            passes: self.passes.saturating_sub(1),
            listed: 0,
            receivers: 0,
            taps: 0,
            samples: 0,
            rays: 0,
            walks: 0,
            ..*self
        }
    }
}

/// Amounts that a cast draws.
struct Drawn {
    /// Number of triangles.
    triangles: u64,
    /// Texels that they cover.
    covered: u64,
    /// Covered texels of alpha-tested triangles.
    cut_out: u64,
}

/// Returns the amounts that a cast draws on a map of `size`.
fn drawn_work(geometry: Option<&Geometry>, cast: &Cast, size: UVec2) -> Drawn {
    let clip_from_world = cast.space.clip_from_world().as_dmat4();
    let mut count = 0;
    let mut area = 0.0;
    let mut area_with_holes = 0.0;
    match (&cast.source, geometry) {
        (Source::Faces(faces), _) => {
            count = faces.triangles.len();
            area = total_area(&faces.triangles, clip_from_world, cast.cull, |v| {
                faces.vertices[v as usize].as_dvec4()
            });
        }
        (_, None) => {}
        (source, Some(geometry)) => {
            let area_of = |run: &Range<u32>| {
                total_area(geometry.run(run), clip_from_world, cast.cull, |v| {
                    geometry.positions()[v as usize].as_dvec3().extend(1.0)
                })
            };
            let runs = source.runs(geometry);
            count = runs.iter().map(ExactSizeIterator::len).sum();
            area = runs.iter().map(area_of).sum();
            if let Some(cut_outs) = geometry.cut_outs() {
                let [_, with_holes] = cut_outs.split(&runs);
                area_with_holes = with_holes.iter().map(area_of).sum();
            }
        }
    }
    // The view's area is four square units.
    let texels_of = |area: f64| {
        let texels = area * 0.25 * f64::from(size.x) * f64::from(size.y);
        texels.round() as u64
    };
    Drawn {
        triangles: count as u64,
        covered: texels_of(area),
        cut_out: texels_of(area_with_holes),
    }
}

/// Returns the sum of the triangles' areas in the view of 2 x 2 clip units. `position` returns a
/// vertex' homogeneous world position.
fn total_area(
    triangles: &[[u32; 3]],
    clip_from_world: DMat4,
    cull: Cull,
    position: impl Fn(u32) -> DVec4 + Sync,
) -> f64 {
    let area_of = |triangle: &[u32; 3]| area(triangle.map(|v| clip_from_world * position(v)), cull);
    // Add chunks in order, so that the sum is the same for any number of threads.
    let chunk_sums: Vec<f64> = triangles
        .par_chunks(1024)
        .map(|chunk| chunk.iter().map(area_of).sum())
        .collect();
    chunk_sums.into_iter().sum()
}

/// Returns the area of a clip-space triangle within the view, or 0 if it is culled.
fn area(corners: [DVec4; 3], cull: Cull) -> f64 {
    let signed = signed_area(corners);
    match cull {
        // Counter-clockwise triangles, with y up, are front faces.
        Cull::Front if signed > 0.0 => 0.0,
        Cull::Back if signed < 0.0 => 0.0,
        // A triangle without extent may be 0 / 0.
        _ if signed.is_finite() => signed.abs(),
        _ => 0.0,
    }
}

/// Planes of the view volume. Inside, the dot product with each is not negative.
const PLANES: [DVec4; 6] = [
    DVec4::new(1.0, 0.0, 0.0, 1.0),
    DVec4::new(-1.0, 0.0, 0.0, 1.0),
    DVec4::new(0.0, 1.0, 0.0, 1.0),
    DVec4::new(0.0, -1.0, 0.0, 1.0),
    DVec4::new(0.0, 0.0, 1.0, 0.0),
    DVec4::new(0.0, 0.0, -1.0, 1.0),
];

/// Returns the area, in the view of 2 x 2 clip units, of the part of a clip-space triangle within
/// the six planes. It is positive for counter-clockwise triangles (y up).
fn signed_area(corners: [DVec4; 3]) -> f64 {
    // Return early for most triangles, which are entirely within the view or beyond one plane.
    // Clipping would return the same bits.
    let distances = PLANES.map(|plane| corners.map(|corner| corner.dot(plane)));
    if distances.iter().any(|d| d.iter().all(|&d| d < 0.0)) {
        return 0.0;
    }
    if distances.as_flattened().iter().all(|&d| d >= 0.0) {
        return fan_area(&corners);
    }
    let mut polygon = ClipPolygon::triangle(corners);
    for plane in PLANES {
        if !polygon.corners().iter().all(|p| p.dot(plane) >= 0.0) {
            polygon = polygon.clip(|p| p.dot(plane), strict_edge_crossing);
        }
    }
    fan_area(polygon.corners())
}

/// Returns the area of a convex polygon in clip space, as a fan of triangles around its first
/// corner. It is 0 with fewer than three corners, and positive for counter-clockwise polygons (y
/// up).
fn fan_area(corners: &[DVec4]) -> f64 {
    let point = |i: usize| DVec2::new(corners[i].x, corners[i].y) / corners[i].w;
    (1..corners.len().max(2) - 1)
        .map(|i| 0.5 * (point(i) - point(0)).perp_dot(point(i + 1) - point(0)))
        .sum()
}

/// Returns the point at which the edge from `a` to `b` crosses a plane, given the signed distances
/// of both. Returns `None` unless they are on opposite sides.
///
/// It differs from [`edge_crossing`](umbrage_core::geometry::clip_polygon::edge_crossing) in two
/// ways. An end on the plane is no crossing, since it would add a second corner at the same
/// position, off by a rounding. The formula must not change, since areas are rounded to whole
/// texels and counts are compared exactly.
fn strict_edge_crossing(a: DVec4, b: DVec4, distance_a: f64, distance_b: f64) -> Option<DVec4> {
    let leaves = distance_a > 0.0 && distance_b < 0.0;
    let enters = distance_a < 0.0 && distance_b > 0.0;
    if !leaves && !enters {
        return None;
    }
    let fraction = distance_a / (distance_a - distance_b);
    Some(a + (b - a) * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64) -> DVec4 {
        DVec4::new(x, y, 0.5, 1.0)
    }

    #[test]
    fn half_of_the_view_is_two_square_units() {
        let triangle = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0)];
        assert!((area(triangle, Cull::None) - 2.0).abs() < 1e-12);
        assert_eq!(area(triangle, Cull::Front), 0.0);
        assert!((area(triangle, Cull::Back) - 2.0).abs() < 1e-12);
    }

    /// Triangles inside, across and outside the view have the area of clipping by all planes, bit
    /// by bit.
    #[test]
    fn what_needs_no_clipping_has_the_same_bits() {
        let random = |i: u32| f64::from(umbrage_core::light_sample::hash(i)) / f64::from(u32::MAX);
        for i in 0..4000 {
            let spread = [0.5, 2.0, 6.0][i as usize % 3];
            let triangle = [0, 1, 2].map(|k: u32| {
                let at = |axis: u32| random(16 * i + 4 * k + axis) - 0.5;
                DVec4::new(spread * at(0), spread * at(1), 0.5 + at(2), 1.0 + at(3))
            });
            let mut clipped = ClipPolygon::triangle(triangle);
            for plane in PLANES {
                clipped = clipped.clip(|p| p.dot(plane), strict_edge_crossing);
            }
            let expected = fan_area(clipped.corners()).abs();
            assert_eq!(
                signed_area(triangle).abs().to_bits(),
                expected.to_bits(),
                "{triangle:?}"
            );
        }
    }

    #[test]
    fn what_lies_next_to_the_view_is_cut_off() {
        // The triangle exceeds all sides: the view is four square units.
        let triangle = [corner(-9.0, -9.0), corner(20.0, -9.0), corner(-9.0, 20.0)];
        assert!((area(triangle, Cull::None) - 4.0).abs() < 1e-12);
        let adjacent = triangle.map(|c| c + DVec4::new(40.0, 0.0, 0.0, 0.0));
        assert_eq!(area(adjacent, Cull::None), 0.0);
    }

    #[test]
    fn a_triangle_through_the_eyes_plane_has_a_finite_area() {
        let triangle = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            DVec4::new(0.0, 3.0, -1.0, -1.0),
        ];
        let area = area(triangle, Cull::None);
        // Its sides leave the view before they reach the plane of depth 0, where they meet at the
        // top.
        assert!((area - 4.0).abs() < 1e-12, "{area}");
        let point = [DVec4::ZERO; 3];
        assert_eq!(super::area(point, Cull::None), 0.0);
    }
}
