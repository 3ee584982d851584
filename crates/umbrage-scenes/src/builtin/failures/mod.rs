//! Scenes in which shadow methods are known to fail.

pub(crate) mod bleeding;
pub(crate) mod corners;
pub(crate) mod cut_outs;
pub(crate) mod distant;
pub(crate) mod facets;
pub(crate) mod fine;
pub(crate) mod lamps;
pub(crate) mod nothing;
pub(crate) mod penumbrae;
pub(crate) mod projection;
pub(crate) mod relief;
pub(crate) mod rooms;
pub(crate) mod scale;
pub(crate) mod shells;
pub(crate) mod spots;
pub(crate) mod stairs;
pub(crate) mod sunlit;
pub(crate) mod volumes;

/// Image size of scenes whose failure is visible in a small image.
const SMALL: [u32; 2] = [320, 240];
