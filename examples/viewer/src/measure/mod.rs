//! Measurements of the view while nothing moves: truth, errors, costs, and where lookups go.

pub(crate) mod agreement;
pub(crate) mod cost;
pub(crate) mod figures;
pub(crate) mod maps;
pub(crate) mod pictures;
pub(crate) mod subject;
pub(crate) mod truth;
