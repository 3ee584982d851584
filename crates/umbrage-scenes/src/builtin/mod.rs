//! Built-in scenes, one function each.

pub(crate) mod causes;
pub(crate) mod closed;
pub(crate) mod content;
pub(crate) mod crowns;
pub(crate) mod failures;
pub(crate) mod figure;
pub(crate) mod noise;
pub(crate) mod speed;
pub(crate) mod teapot;
pub(crate) mod textbook;
pub(crate) mod textbook_rooms;

/// Size of the compared images.
pub(crate) const SIZE: [u32; 2] = [480, 270];
