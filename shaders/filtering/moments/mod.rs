//! Maps of moments: means of functions of depth, which can be blurred and blended as depth itself
//! can't, and what they say of how much of a neighbourhood lies beyond a receiver.
//!
//! In the order of a recipe: `of_depth.rs` (which moments a texel holds), `stored.rs` (moments as
//! channels of 16 bits), `blur.rs` (one axis of the box), `halve.rs` (the levels of mipmaps, all in
//! one image, so that a kernel reads two images at most), `map.rs` (the images and filters of a
//! recipe), `mipmaps.rs` (which levels answer a pixel), `look_up.rs` (the blend of four texels);
//! then how much light moments allow: `bounds.rs` (Chebyshev), `hamburger.rs`, `hausdorff.rs`.
//! `exp2.rs` is there since drivers round `exp2` as they like. Drivers also simplify sums that have
//! a term in common: where bits must be equal, differences are put in ready-made (see
//! `hausdorff.rs`).

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
