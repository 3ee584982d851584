//! The corner of a room, lit from inside.

use super::SMALL;
use crate::{
    primitives::{block, icosphere, room},
    stage::{Stage, bulb},
};
use umbrage_core::Scene;
use umbrage_core::glam::Vec3;

/// Two walls and the floor meet at the origin. All three are lit, and all three cast. A kernel
/// whose taps follow one wall's plane continues behind the neighbouring wall, and a bias along a
/// normal moves receivers towards that wall. The shadows of a stool and a ball end in the corner,
/// so that too much bias shows there, too.
pub(crate) fn room_corner() -> Scene {
    Stage::new("room-corner")
        .put(room(Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0)))
        .put(block([0.35, 0.0, 0.6], [0.75, 0.5, 1.0]))
        .put(icosphere([0.7, 1.1, 0.35], 0.25, 3))
        .light(bulb(2.9, 2.3, 0.5))
        .shoot([2.3, 1.6, 3.3], [0.0, 0.75, 0.0], 45.0, SMALL)
}
