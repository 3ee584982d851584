//! What the camera sees: receivers, and how pixels become them.

pub(crate) mod receivers;
pub mod resolve;
pub(crate) mod seen_points;
