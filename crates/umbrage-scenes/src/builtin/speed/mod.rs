//! Large scenes, for measuring speed.

pub(crate) mod hall;
pub(crate) mod statue;
pub(crate) mod terrain;
pub(crate) mod town;

/// Image size at which lookups are timed.
pub(crate) const SIZE: [u32; 2] = [1280, 720];
