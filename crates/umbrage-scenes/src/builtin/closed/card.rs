//! c10: a card whose alpha texture cuts out every second square.

use super::{SIZE, exact, floor, sheet};
use crate::{
    ClosedForm,
    looks::chequered_holes,
    stage::{Stage, sun},
};
use umbrage_core::Scene;

/// Squares along each side of the card.
const SQUARES: u32 = 6;
/// Half the card's side, metres.
const HALF: f32 = 1.2;
/// Offset of the shadow from the card along x, metres: half the card's height.
const SHIFT: f32 = 0.5;

pub(crate) fn chequered_card() -> Scene {
    Stage::new("c10-chequered-card")
        .put(floor(4.0))
        .put(sheet([-HALF, HALF], [-HALF, HALF], 1.0))
        .look(chequered_holes(SQUARES))
        .light(sun(1.0, -2.0, 0.0))
        // Look from below the card, so that it doesn't hide its shadow.
        .shoot([SHIFT, 0.8, 4.2], [SHIFT, 0.0, 0.0], 40.0, SIZE)
}

/// Samples in the shadow or light of each square: its centre, and points 1 cm inside its sides.
pub(crate) fn chequered_card_samples() -> ClosedForm {
    const INSET: f32 = 0.01;
    let side = 2.0 * HALF / SQUARES as f32;
    let aside = 0.5 * side - INSET;
    let mut points = Vec::new();
    for k in 0..SQUARES {
        for i in 0..SQUARES {
            let x = SHIFT - HALF + side * (i as f32 + 0.5);
            let z = -HALF + side * (k as f32 + 0.5);
            // The texture's lower left square, at the least x and z, is cut out.
            let visibility = f32::from(u8::from((i + k).is_multiple_of(2)));
            for (dx, dz) in [
                (0.0, 0.0),
                (-aside, 0.0),
                (aside, 0.0),
                (0.0, -aside),
                (0.0, aside),
            ] {
                points.push((x + dx, z + dz, visibility));
            }
        }
    }
    let beyond = HALF + INSET;
    points.extend([-beyond, beyond].map(|x| (x + SHIFT, 0.1, 1.0)));
    points.extend([-beyond, beyond].map(|z| (SHIFT + 0.1, z, 1.0)));
    exact(&points)
}
