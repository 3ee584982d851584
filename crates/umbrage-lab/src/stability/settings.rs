//! Which settings of each technique the matrix shows.

use std::sync::Arc;
use umbrage_core::{Fit, ShadowTechnique};
use umbrage_techniques::{ConfiguredTechniques, Techniques};

/// One or two settings of every technique of the registry (or of those named): the textbooks' (a slope bias or a polygon
/// offset, else the first listed), and the best behaved (the last that follows the receiver's plane, else the last).
pub fn settings(
    registry: &Techniques,
    techniques: &[String],
    map_size: u32,
    fit: Fit,
) -> ConfiguredTechniques {
    let wanted = |name: &str| techniques.is_empty() || techniques.iter().any(|t| t == name);
    let entries = registry.all().iter().filter(|e| wanted(e.name));
    entries
        .flat_map(|e| two_of((e.settings)(&[map_size], fit)))
        .collect()
}

fn two_of(all: ConfiguredTechniques) -> ConfiguredTechniques {
    let says = |t: &Arc<dyn ShadowTechnique>, word: &str| t.settings().contains(word);
    let textbook = all
        .iter()
        .find(|t| says(t, "slope") || says(t, "polygon offset"))
        .or(all.first());
    let best = all
        .iter()
        .rev()
        .find(|t| says(t, "receiver plane"))
        .or(all.last());
    let mut out: ConfiguredTechniques = textbook.into_iter().cloned().collect();
    out.extend(
        best.filter(|b| out.iter().all(|t| t.settings() != b.settings()))
            .cloned(),
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_technique_has_one_or_two_settings_that_differ() {
        let chosen = settings(&Techniques::built_in(), &[], 256, Fit::Tight);
        for entry in umbrage_techniques::all() {
            let its: Vec<String> = chosen
                .iter()
                .filter(|t| t.name() == entry.name)
                .map(|t| t.settings())
                .collect();
            assert!(
                matches!(its.len(), 1 | 2) && its.first() != its.get(1),
                "{}: {its:?}",
                entry.name
            );
        }
        let hard: Vec<String> = settings(
            &Techniques::built_in(),
            &["hard".to_owned()],
            256,
            Fit::Tight,
        )
        .iter()
        .map(|t| t.settings())
        .collect();
        assert!(
            hard.len() == 2 && hard[0].contains("slope") && hard[1].contains("receiver plane"),
            "{hard:?}"
        );
    }
}
