//! Sunlight of surfaces as numbers, for those who need no picture.
//!
//! [`Facets`] is a list of triangles in 64-bit coordinates. It answers:
//!
//! * [`Facets::lit_area`]: the lit area of each facet, exact but for rounding, its projection and
//!   its centre. The facets' own polygons are cut; nothing is sampled.
//! * [`Facets::lit`]: which [`Points`] are lit.
//! * [`Facets::sun_hours`]: when points are lit, as spans of time.
//! * [`Facets::disc_share`]: the share of the Sun's disc that points see;
//!   [`Facets::lit_area_of_disc`] averages lit areas over it.
//!
//! Each answer comes with [`Stated`]: its undecided rows, its margin in metres, a check of the
//! areas, the step in time, and a hash. Answers have the same bits on any number of threads.
//!
//! ```
//! use glam::{DVec3, dvec3};
//! use umbrage_surfaces::{Facets, Options, Suns};
//!
//! // A floor of 2 m x 2 m, and a plate of 1 m x 1 m above its middle.
//! let square = |half: f64, z: f64| {
//!     [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
//!         .map(|[x, y]| dvec3(half * x, half * y, z))
//! };
//! let vertices = [square(1.0, 0.0), square(0.5, 0.3)].concat();
//! let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
//! let options = Options { unit_m: Some(1.0), ..Options::default() };
//! let facets = Facets::new(&vertices, &triangles, &options)?;
//!
//! let mut lit = 0.0;
//! let stated = facets.lit_area(&Suns::new(&[DVec3::Z])?, |_sun, areas| {
//!     lit = areas.iter().map(|facet| facet.area).sum();
//! });
//! assert!((lit - 4.0).abs() < 1e-12);
//! println!("{stated}");
//! # Ok::<(), umbrage_surfaces::FacetsError>(())
//! ```

mod clip;
mod disc;
mod facets;
mod grid;
mod lit;
mod lit_area;
mod morton;
mod options;
mod points;
mod polygons;
mod rays;
mod stated;
mod sun_hours;
mod suns;
mod tree;

pub use disc::{Disc, DiscShares};
pub use facets::Facets;
pub use glam;
pub use lit::Lit;
pub use lit_area::LitArea;
pub use options::{Options, Sides, Up, metres_of_unit};
pub use points::Points;
pub use stated::Stated;
pub use sun_hours::{Day, SunHours};
pub use suns::{Suns, direction_at};
/// Error of facets, points, suns or days: what is wrong, why, and what to do. It names rows, which
/// count from 0.
pub use umbrage_core::Invalid as FacetsError;
