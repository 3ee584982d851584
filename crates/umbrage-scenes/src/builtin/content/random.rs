//! Pseudo-random numbers that are equal on every platform.

use crate::builtin::noise::uniform;
use umbrage_core::glam::{IVec3, Vec3};

/// Calls `put` for a random position in each cell of a grid over the square of this half side
/// around the origin. `put` receives x and z, and the source of all further numbers of the cell.
/// Cells for which it returns `None` stay empty.
pub(in crate::builtin) fn scatter_points<T>(
    seed: i32,
    half: f32,
    pitch: f32,
    mut put: impl FnMut([f32; 2], &mut Random) -> Option<T>,
) -> Vec<T> {
    let mut random = Random::new(seed);
    let cells = (2.0 * half / pitch) as u32;
    let mut out = Vec::new();
    for k in 0..cells {
        for i in 0..cells {
            let x = pitch * (i as f32 + random.number_between(0.1, 0.9)) - half;
            let z = pitch * (k as f32 + random.number_between(0.1, 0.9)) - half;
            out.extend(put([x, z], &mut random));
        }
    }
    out
}

/// A sequence of numbers determined by its seed.
#[derive(Clone, Debug)]
pub(in crate::builtin) struct Random {
    seed: i32,
    /// Number of numbers drawn so far.
    drawn: i32,
}

impl Random {
    pub(in crate::builtin) fn new(seed: i32) -> Self {
        Self { seed, drawn: 0 }
    }

    /// Returns the next number, 0 to 1.
    pub(in crate::builtin) fn unit(&mut self) -> f32 {
        self.drawn += 1;
        uniform(IVec3::new(self.seed, self.drawn, 11))
    }

    /// Returns the next number between two bounds.
    pub(in crate::builtin) fn number_between(&mut self, least: f32, most: f32) -> f32 {
        least + (most - least) * self.unit()
    }

    /// Returns the next number between `-most` and `most`.
    pub(in crate::builtin) fn signed_number(&mut self, most: f32) -> f32 {
        self.number_between(-most, most)
    }

    /// Returns a vector with coordinates from -1 to 1.
    pub(in crate::builtin) fn vector(&mut self) -> Vec3 {
        let x = self.signed_number(1.0);
        let y = self.signed_number(1.0);
        let z = self.signed_number(1.0);
        Vec3::new(x, y, z)
    }

    /// Returns `true` with this probability.
    pub(in crate::builtin) fn chance(&mut self, probability: f32) -> bool {
        self.unit() < probability
    }
}
