//! What all techniques with a shadow map share: the map, its fit and bias. The way from a receiver
//! to a texel is [`coord`]'s.
//!
//! Williams 1978, "Casting curved shadows on curved surfaces": draw the scene's depth as the light
//! sees it; a point is lit if, seen from the light, nothing nearer was drawn at its texel. Points
//! outside the map, beyond its far plane or behind the light are lit.
//!
//! Known failures of every map, whatever looks it up (each is a row of `cargo xtask stability`):
//!
//! * **Edges crawl** where the fit follows the camera or the light turns: texels meet edges
//!   elsewhere in every frame. What is as thin as a texel (wires, grass) comes and goes.
//! * **Contacts leak**: within a texel of where a thin caster stands, and within a kernel's reach,
//!   light comes through.
//! * **Lights with an extent count as their middle**, but for [`Pcss`](crate::Pcss): penumbrae have
//!   the kernel's width or none.
//! * **Far from the origin** positions are rounded (to 8 mm at 1e5 m, 6 cm at 1e6 m): fits jump
//!   from frame to frame, and biases that follow the receiver closely ([`Bias::ADAPTIVE`]) show
//!   acne that flickers.
//! * **Cascades change their texels' size** from one to the next, which shows as a step along edges
//!   unless their answers blend; and what a stable one does not reach is lit.
//! * **16 bits** over a long range store depth in steps that show as acne under any bias that is
//!   right for 32.

mod between;
mod bias;
pub mod cascades;
pub mod coord;
pub mod layers;
pub mod packing;
pub(crate) mod position_error;
mod settings;
pub mod texel_compare;
pub(crate) mod variants;

pub use between::BetweenKernel;
pub use bias::{Bias, CompareMethod};
pub use settings::{BeyondFar, Border, MapFormat, Maps, SIDE_STEP, ShadowMap, Surface};
