//! Moment maps: means of functions of depth, which can be blurred and blended, unlike depth itself.
//! They bound the fraction of a neighbourhood that is beyond a receiver.
//!
//! Modules in the order of a recipe:
//!
//! - `of_depth.rs`: the moments of a texel
//! - `stored.rs`: moments as channels of 16 bits
//! - `blur.rs`: the filter that averages them over squares; `tile.rs`: the tiles of its workgroups
//! - `halve.rs`: the levels of mipmaps, all in one image, so that a kernel reads at most two images
//! - `map.rs`: the images and filters of a recipe
//! - `mipmaps.rs`: the levels for a pixel
//! - `look_up.rs`: the blend of four texels
//! - `bounds.rs` (Chebyshev), `hamburger.rs`, `hausdorff.rs`: the bound of light from moments
//! - `exp2.rs`: a power of two with the same rounding on all drivers
//!
//! Drivers also simplify sums with a common term. If bits must be equal, differences are
//! precomputed (see `hausdorff.rs`).

pub(crate) mod blur;
pub(crate) mod bounds;
pub(crate) mod exp2;
pub(crate) mod halve;
pub(crate) mod hamburger;
pub(crate) mod hausdorff;
pub(crate) mod look_up;
pub(crate) mod map;
pub(crate) mod mipmaps;
pub(crate) mod of_depth;
pub(crate) mod stored;
pub(crate) mod tile;
