//! Shadow maps: the map, its fit and its bias, which all map techniques share. The module [`coord`]
//! projects receivers to texels.
//!
//! Williams 1978, "Casting curved shadows on curved surfaces": render the scene's depth from the
//! light. A point is lit if nothing nearer to the light was drawn at its texel. Points outside the
//! map, beyond its far plane or behind the light are lit.
//!
//! Known failures of every map, independent of the lookup (each is a row of
//! `cargo xtask stability`):
//!
//! - **Edges crawl** if the fit follows the camera or the light turns, since texels meet edges at
//!   other positions in every frame. Objects as thin as a texel (wires, grass) flicker.
//! - **Contacts leak**: light leaks within a texel of the base of a thin caster, and within the
//!   kernel's reach.
//! - **Area lights count as their centre**, except with [`Pcss`](crate::Pcss): penumbrae have the
//!   kernel's width or none.
//! - **Far from the origin** positions are rounded (to 8 mm at 1e5 m, 6 cm at 1e6 m). Fits jump
//!   from frame to frame. Biases that follow the receiver closely ([`Bias::ADAPTIVE`]) show acne
//!   that flickers.
//! - **Cascades differ in texel size**, which shows as a step along edges unless they blend.
//!   Receivers outside all stable cascades are lit.
//! - **16 bits** over a long range store depth in steps. These show as acne under any bias that is
//!   right for 32 bits.

mod between;
mod bias;
pub mod cascades;
pub mod coord;
pub mod layers;
mod maps;
pub mod packing;
pub(crate) mod position_error;
mod settings;
pub mod texel_compare;
pub(crate) mod variants;

pub use between::BetweenKernel;
pub use bias::{Bias, CompareMethod};
pub use maps::Maps;
pub use settings::{BeyondFar, Border, MapFormat, SIDE_STEP, ShadowMap, Surface};
