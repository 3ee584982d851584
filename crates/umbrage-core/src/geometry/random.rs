//! Deterministic pseudo-random numbers for tests.

use crate::scene::light_sample::hash;
use glam::Vec3;

/// A sequence of numbers: each is the hash of its predecessor.
pub(in crate::geometry) struct Random(pub(in crate::geometry) u32);

impl Random {
    /// Returns the next number, -1 to 1.
    pub(in crate::geometry) fn signed_unit(&mut self) -> f32 {
        self.0 = hash(self.0);
        self.0 as f32 / 2_147_483_648.0 - 1.0
    }

    /// Returns the next number, 0 to below 1.
    pub(in crate::geometry) fn unit(&mut self) -> f32 {
        self.0 = hash(self.0);
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    /// Returns a vector of three [`Random::signed_unit`] numbers.
    pub(in crate::geometry) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed_unit(), self.signed_unit(), self.signed_unit())
    }
}
