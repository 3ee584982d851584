//! What is measured of the view while nothing moves: truth, errors, and where lookups go.

pub(crate) mod against_cpu;
pub(crate) mod cost;
pub(crate) mod figures;
pub(crate) mod places;
pub(crate) mod truth;
pub(crate) mod view_figures;
pub(crate) mod worker;
