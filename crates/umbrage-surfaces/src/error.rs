//! Input that can't be used: what is wrong, where, and what to do.

use glam::DVec3;

/// Error of facets, points or suns. Rows count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FacetsError {
    /// There is no triangle.
    #[error("there are no facets; pass at least one triangle")]
    Empty,
    /// More rows than 32 bits count.
    #[error("there are {rows} {what}; split them into parts of at most 2^31")]
    TooMany {
        /// Vertices or facets.
        what: &'static str,
        /// Their number.
        rows: usize,
    },
    /// A number that is not finite.
    #[error("{what} {row}: is not finite; use finite numbers")]
    NotFinite {
        /// Vertex, point or normal.
        what: &'static str,
        /// Its row.
        row: usize,
    },
    /// A vertex index out of range.
    #[error(
        "facet {row}: has the vertex {index}, but there are {vertices}; use indices below that"
    )]
    Index {
        /// The facet.
        row: usize,
        /// The index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Lists whose lengths must agree.
    #[error("there are {has} {what} for {wants} rows; use one for each row")]
    Counts {
        /// The list with the wrong length.
        what: &'static str,
        /// Its length.
        has: usize,
        /// The wanted length.
        wants: usize,
    },
    /// A setting out of range.
    #[error("{what}: is {value}; use a finite number greater than zero")]
    Setting {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Coordinates that 64 bits can't hold to the tolerance.
    #[error(
        "coordinates reach {reach_m:.3e} m, where answers are uncertain by {loses_m:.1e} m; \
         move the origin nearer, check the unit, or allow for it with `max_error_m`"
    )]
    TooFar {
        /// Greatest distance from the origin along an axis, metres.
        reach_m: f64,
        /// Margin of answers at that distance, metres.
        loses_m: f64,
    },
    /// Lengths that are improbable in the unit, which was not stated.
    #[error("the facets are {extent_m} m long: {suspect}? State the unit, also if it is metres")]
    Unit {
        /// Length of the box around the facets, metres.
        extent_m: f64,
        /// The probable unit.
        suspect: &'static str,
    },
    /// A normal without a direction.
    #[error("point {row}: has a zero normal; pass a direction, or no normals for both sides")]
    NoNormal {
        /// The point.
        row: usize,
    },
    /// A sun without a direction or weight.
    #[error("sun {row}: has the direction {direction} and the weight {weight}; use finite ones")]
    BadSun {
        /// The sun.
        row: usize,
        /// Its direction.
        direction: DVec3,
        /// Its weight.
        weight: f64,
    },
    /// Open or inconsistently turned edges, with [`Sides::Front`](crate::Sides::Front).
    #[error(
        "{edges} edges, such as those of the facets {rows:?}, have no neighbour that is turned \
         alike; close the mesh, or use both sides"
    )]
    Open {
        /// Number of such edges.
        edges: usize,
        /// The first facets with such edges.
        rows: Vec<u32>,
    },
    /// Bodies that face inwards, with [`Sides::Front`](crate::Sides::Front).
    #[error(
        "{facets} facets, such as {rows:?}, are of bodies that face inwards; \
         swap two corners of each of these facets, or use both sides"
    )]
    Inverted {
        /// Number of their facets.
        facets: usize,
        /// The first such facets.
        rows: Vec<u32>,
    },
}
