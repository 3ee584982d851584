//! Access to a set for tests.

use crate::{
    light_set::{LightSet, prices::Prices},
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

    /// Sets the capacity of all hierarchies for references: this number, or one for each caster if
    /// there are more. `None` restores the default.
    pub fn limit_references(&mut self, most: Option<u32>) {
        self.hierarchies.most_references = most;
    }

    /// Returns the number of GPU objects created so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }
}
