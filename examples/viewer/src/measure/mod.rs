//! Measurements of the view at rest: the reference, errors, costs, and lookups.

pub(crate) mod agreement;
pub(crate) mod cost;
pub(crate) mod figures;
pub(crate) mod maps;
pub(crate) mod pictures;
pub(crate) mod subject;
pub(crate) mod truth;
