//! Access to a set for tests.

use crate::{
    light_set::{LightId, LightSet, caster_lists::Listing, prices::Prices},
    resources::counters::Counters,
};

impl LightSet {
    /// Sets the costs of drawing a triangle and of copying a texel, seconds, instead of measuring
    /// them.
    pub fn assume_prices(&mut self, triangle: f64, texel: f64) {
        self.meter.assume(Prices {
            triangle: Some(triangle),
            texel: Some(texel),
        });
    }

    /// Returns the measured costs of drawing a triangle and of copying a texel, seconds.
    pub fn measured_prices(&self) -> [Option<f64>; 2] {
        let prices = self.meter.prices();
        [prices.triangle, prices.texel]
    }

    /// Limits the capacity of all lists to this number of items.
    pub fn limit_listed_items(&mut self, most: Option<u32>) {
        self.lists.limits.most = most;
    }

    /// Sets the initial capacity of lists for items.
    pub fn begin_with_listed_items(&mut self, first: u32) {
        self.lists.limits.first = Some(first);
    }

    /// Waits for the last lists of a light, and returns their result; `None` if there are none.
    pub fn listings(&mut self, id: LightId) -> Option<Listing> {
        let key = id.key_in(self.number).ok()?;
        self.lists.look(&self.device, key)
    }

    /// Returns the number of GPU objects created so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }
}
