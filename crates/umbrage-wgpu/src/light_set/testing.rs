//! Access to a set for tests.

use crate::{
    light_set::{LightSet, caster_lists::Listing, options::LightId, prices::Prices},
    resources::counters::Counters,
};

impl LightSet {
    /// Sets what drawing a triangle and copying a texel take, seconds, instead of measuring it.
    pub fn assume_prices(&mut self, triangle: f64, texel: f64) {
        self.meter.assume(Prices {
            triangle: Some(triangle),
            texel: Some(texel),
        });
    }

    /// Returns what drawing a triangle and copying a texel were measured to take, seconds.
    pub fn measured_prices(&self) -> [Option<f64>; 2] {
        let prices = self.meter.prices();
        [prices.triangle, prices.texel]
    }

    /// Gives all lists room for at most so many items.
    pub fn limit_listed_items(&mut self, most: Option<u32>) {
        self.lists.limits.most = most;
    }

    /// Gives lists room for so many items before it is known how many they need.
    pub fn begin_with_listed_items(&mut self, first: u32) {
        self.lists.limits.first = Some(first);
    }

    /// Waits for the last lists of a light, and returns how they were made; none if there are none.
    pub fn listings(&mut self, id: LightId) -> Option<Listing> {
        self.lists.look(&self.device, id)
    }

    /// Returns how many GPU objects were made so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }
}
