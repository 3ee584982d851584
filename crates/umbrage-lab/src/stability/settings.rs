//! Chooses the settings of each technique that the matrix shows.

use std::sync::Arc;
use umbrage_core::{Fit, ShadowTechnique};
use umbrage_techniques::{ConfiguredTechniques, Techniques};

/// Returns one or two settings of every technique of the registry (or of those named): the one that textbooks have (the first
/// with a slope bias or a polygon offset, else the first), and the one with fewest artifacts (the last whose bias follows the
/// receiver's plane, else the last). With another fit than the tight one, techniques without a map are left out: it changes
/// nothing for them.
pub fn settings(
    registry: &Techniques,
    techniques: &[String],
    map_size: u32,
    fit: Fit,
) -> ConfiguredTechniques {
    let mut out = Vec::new();
    for entry in registry.all() {
        if fit != Fit::Tight && !entry.has_map {
            continue;
        }
        if techniques.is_empty() || techniques.iter().any(|name| name == entry.name) {
            let all = (entry.settings)(&[map_size], fit);
            out.extend(one_or_two_of(&all));
        }
    }
    out
}

/// Returns the textbooks' setting and, if it differs, the one with fewest artifacts.
fn one_or_two_of(all: &[Arc<dyn ShadowTechnique>]) -> ConfiguredTechniques {
    let textbook = all
        .iter()
        .find(|t| has_word(&***t, "slope") || has_word(&***t, "polygon offset"))
        .or(all.first());
    let best = all
        .iter()
        .rev()
        .find(|t| has_word(&***t, "receiver plane"))
        .or(all.last());
    let (Some(textbook), Some(best)) = (textbook, best) else {
        return Vec::new();
    };
    if textbook.settings() == best.settings() {
        vec![textbook.clone()]
    } else {
        vec![textbook.clone(), best.clone()]
    }
}

fn has_word(technique: &dyn ShadowTechnique, word: &str) -> bool {
    technique.settings().contains(word)
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
        let stable = Fit::Stable { range: 8.0 };
        let with_map: Vec<&str> = umbrage_techniques::all()
            .iter()
            .filter(|entry| entry.has_map)
            .map(|entry| entry.name)
            .collect();
        let mut in_stable_fit: Vec<&str> = settings(&Techniques::built_in(), &[], 256, stable)
            .iter()
            .map(|t| t.name())
            .collect();
        in_stable_fit.dedup();
        assert_eq!(in_stable_fit, with_map);
        let names = ["hard".to_owned()];
        let of_hard = settings(&Techniques::built_in(), &names, 256, Fit::Tight);
        let hard: Vec<String> = of_hard.iter().map(|t| t.settings()).collect();
        assert!(
            hard.len() == 2 && hard[0].contains("slope") && hard[1].contains("receiver plane"),
            "{hard:?}"
        );
    }
}
