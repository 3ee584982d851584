//! Selects the settings of each technique for the matrix.

use umbrage_core::Fit;
use umbrage_plan::catalogue::Catalogue;
use umbrage_techniques::TechniquePreset;

/// Returns the settings to run for every technique of the catalogue, or only the named ones.
///
/// They are the textbook setting (the first with a slope bias or a polygon offset, else the first),
/// and those that represent the technique in a comparison of full-size scenes
/// ([`CatalogueEntry::headline`](umbrage_plan::catalogue::CatalogueEntry::headline)). So a
/// comparison's rows have their own verdicts. With another fit than the tight one, techniques
/// without a map are omitted: the fit doesn't affect them.
pub fn settings(
    catalogue: &Catalogue,
    techniques: &[String],
    map_size: u32,
    fit: Fit,
) -> Vec<TechniquePreset> {
    let mut out = Vec::new();
    for entry in catalogue.all() {
        if fit != Fit::Tight && !entry.technique.has_map {
            continue;
        }
        if techniques.is_empty() || techniques.iter().any(|name| name == entry.technique.name) {
            let all = (entry.settings)(&[map_size], fit);
            let headline = (entry.headline)(&[map_size], fit);
            out.extend(distinct(textbook(&all).into_iter().chain(headline)));
        }
    }
    out
}

/// Returns the textbook setting.
fn textbook(all: &[TechniquePreset]) -> Option<TechniquePreset> {
    let usual = all.iter().find(|preset| {
        let words = preset.settings();
        words.contains("slope") || words.contains("polygon offset")
    });
    usual.or(all.first()).cloned()
}

/// Returns the distinct settings.
fn distinct(settings: impl Iterator<Item = TechniquePreset>) -> Vec<TechniquePreset> {
    let mut out: Vec<TechniquePreset> = Vec::new();
    for setting in settings {
        if !out.contains(&setting) {
            out.push(setting);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use umbrage_core::ShadowTechnique as _;

    #[test]
    fn every_technique_has_one_to_four_settings_that_differ() {
        let chosen = settings(&Catalogue::built_in(), &[], 256, Fit::Tight);
        for entry in umbrage_plan::catalogue::all() {
            let its: Vec<String> = chosen
                .iter()
                .filter(|t| t.name() == entry.technique.name)
                .map(|t| t.settings())
                .collect();
            let distinct: HashSet<&String> = its.iter().collect();
            assert!(
                matches!(its.len(), 1..=4) && distinct.len() == its.len(),
                "{}: {its:?}",
                entry.technique.name
            );
            let default = (entry.technique.preset)();
            let bias = default.map().map(|map| map.bias.label());
            assert!(
                bias.is_none_or(|bias| its.iter().any(|words| words.ends_with(&bias))),
                "{}: its default bias is missing: {its:?}",
                entry.technique.name
            );
        }
        let stable = Fit::Stable { range: 8.0 };
        let with_map: Vec<&str> = umbrage_plan::catalogue::all()
            .iter()
            .filter(|entry| entry.technique.has_map)
            .map(|entry| entry.technique.name)
            .collect();
        let mut in_stable_fit: Vec<&str> = settings(&Catalogue::built_in(), &[], 256, stable)
            .iter()
            .map(|t| t.name())
            .collect();
        in_stable_fit.dedup();
        assert_eq!(in_stable_fit, with_map);
        let names = ["hard".to_owned()];
        let of_hard = settings(&Catalogue::built_in(), &names, 256, Fit::Tight);
        let hard: Vec<String> = of_hard.iter().map(|t| t.settings()).collect();
        assert!(
            hard.len() == 3
                && hard[0].contains("slope")
                && hard[1].contains("adaptive")
                && hard[2].contains("cascades"),
            "{hard:?}"
        );
    }
}
