//! Maps of moments: means of functions of depth, which can be blurred and blended as depth itself can't, and what they say of how
//! much of a neighbourhood lies beyond a receiver.

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
