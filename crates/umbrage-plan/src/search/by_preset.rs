//! A map keyed by preset.

use std::collections::HashMap;
use umbrage_core::ShadowTechnique as _;
use umbrage_techniques::{Bias, ShadowMap, TechniquePreset};

/// Map from presets to values. Floats can't be hashed, so presets of one technique are compared
/// linearly. That is cheap compared with evaluating a preset. A preset with NaN is never found.
#[derive(Debug)]
pub(super) struct ByPreset<V>(HashMap<&'static str, Vec<(TechniquePreset, V)>>);

impl<V> Default for ByPreset<V> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<V> ByPreset<V> {
    /// Returns the value of a preset.
    pub(super) fn get(&self, preset: &TechniquePreset) -> Option<&V> {
        let known = self.0.get(preset.name())?;
        known
            .iter()
            .find_map(|(key, value)| (key == preset).then_some(value))
    }

    /// Sets the value of a preset.
    pub(super) fn insert(&mut self, preset: TechniquePreset, value: V) {
        let known = self.0.entry(preset.name()).or_default();
        match known.iter_mut().find(|(key, _)| *key == preset) {
            Some((_, old)) => *old = value,
            None => known.push((preset, value)),
        }
    }

    /// Returns all values, in unspecified order.
    pub(super) fn values(&self) -> impl Iterator<Item = &V> {
        self.0.values().flatten().map(|(_, value)| value)
    }

    /// Returns the number of presets.
    pub(super) fn len(&self) -> usize {
        self.0.values().map(Vec::len).sum()
    }

    /// Removes all presets.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

/// Returns the preset without its bias, or unchanged if it has no map.
pub(super) fn without_bias(preset: &TechniquePreset) -> TechniquePreset {
    let unbiased = preset.map().map(|&map| ShadowMap {
        bias: Bias::NONE,
        ..map
    });
    match unbiased {
        Some(map) => preset.with_map(map),
        None => preset.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_techniques::{Hard, MapFilter as _, MapTechnique, Pcf};

    #[test]
    fn presets_are_known_by_technique_and_numbers() {
        let map = |bias| ShadowMap {
            bias,
            ..ShadowMap::default()
        };
        let hard = TechniquePreset::from(MapTechnique::<Hard>::default());
        let biased = TechniquePreset::from(Hard {}.on(map(Bias::SLOPE)));
        let pcf = TechniquePreset::from(MapTechnique::<Pcf>::default());
        let mut known = ByPreset::default();
        known.insert(hard.clone(), 1);
        known.insert(biased.clone(), 2);
        known.insert(hard.clone(), 3);
        assert_eq!(known.get(&hard), Some(&3));
        assert_eq!(known.get(&biased), Some(&2));
        assert_eq!((known.get(&pcf), known.len()), (None, 2));
        assert_eq!(without_bias(&biased), without_bias(&hard));
        assert_ne!(without_bias(&pcf), without_bias(&hard));
        known.clear();
        assert_eq!(known.values().count(), 0);
    }
}
