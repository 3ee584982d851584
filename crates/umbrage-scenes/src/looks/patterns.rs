//! Flat patterns.

use super::{Look, texture, textured_look};
use crate::builtin::noise::{fractal, uniform};
use umbrage_core::glam::{IVec3, Vec2, Vec3};

const SIDE: u32 = 128;
const PLANKS: f32 = 4.0;

/// Two greys, two by two squares.
pub(crate) fn checker() -> Look {
    textured_look(texture("checker", 16, |uv| {
        Vec3::splat(if (uv.x < 0.5) == (uv.y < 0.5) {
            0.55
        } else {
            0.3
        })
    }))
}

/// Four planks along u, each with its grain.
pub(crate) fn wood() -> Look {
    textured_look(texture("wood", SIDE, plank))
}

fn plank(uv: Vec2) -> Vec3 {
    let along = uv.x;
    let across = uv.y * PLANKS;
    let number = across.floor();
    let grain = fractal(Vec3::new(3.0 * along, 9.0 * across, 10.0 * number), 4);
    let tone = 0.85 + 0.3 * uniform(IVec3::new(number as i32, 7, 1)) + 0.35 * grain;
    // Planks are separated by dark lines. They are as long as the texture, and every other one is
    // shifted by half.
    let from_end = (along + 0.5 * (number % 2.0)).fract();
    let joint = across.fract().min(1.0 - across.fract()) < 0.03 || from_end < 0.008;
    Vec3::new(0.44, 0.25, 0.11) * if joint { 0.35 } else { tone }
}
