//! Scenes in which shadow methods are known to fail.

pub(crate) mod nothing;
pub(crate) mod rooms;
pub(crate) mod scale;
pub(crate) mod stairs;
pub(crate) mod sunlit;
