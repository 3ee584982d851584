//! Visible surface points: receivers, and their computation from pixels.

pub(crate) mod points;
pub(crate) mod receivers;
pub mod resolve;
pub(crate) mod seen_points;
