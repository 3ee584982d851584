//! The settings to compare on a scene, with names for readers and files.

use super::options::{CompareOptions, NamedPreset, SceneInput};
use crate::{error::LabError, output::slug};
use umbrage_core::{Fit, Invalid, ShadowTechnique as _};
use umbrage_techniques::TechniquePreset;

/// A technique setting with a unique stem of file names.
#[derive(Clone, Debug)]
pub(super) struct NamedSetting {
    pub(super) technique: TechniquePreset,
    /// The technique's name, or the preset's.
    pub(super) name: String,
    /// The settings. For a preset, the technique comes first.
    pub(super) settings: String,
    pub(super) slug: String,
}

/// Returns all settings to compare on a scene.
pub(super) fn settings_of(
    input: &SceneInput,
    options: &CompareOptions,
) -> Result<Vec<NamedSetting>, LabError> {
    let options = input.options_or(options);
    let tight = options.settings(Fit::Tight)?;
    let all = with_fit(&tight, input.fit, options)?;
    Ok(with_slugs(&options.presets, &all))
}

/// Returns the settings, then those with the scene's own fit. Settings without a map occur once.
pub(super) fn with_fit(
    tight: &[TechniquePreset],
    fit: Option<Fit>,
    options: &CompareOptions,
) -> Result<Vec<TechniquePreset>, LabError> {
    let mut out = tight.to_vec();
    let Some(fit) = fit else {
        return Ok(out);
    };
    for setting in options.settings(fit)? {
        if !tight.contains(&setting) {
            out.push(setting);
        }
    }
    Ok(out)
}

impl CompareOptions {
    /// Returns the technique settings to compare, with this fit of their maps.
    ///
    /// # Errors
    /// Errors if a name is unknown or a map size is missing.
    pub(super) fn settings(&self, fit: Fit) -> Result<Vec<TechniquePreset>, LabError> {
        let mut chosen = self.catalogue.select(&self.techniques)?;
        if self.is_preview && self.techniques.is_empty() {
            chosen.retain(|entry| entry.is_previewed);
        }
        if self.map_sizes.is_empty() {
            return Err(Invalid::new(
                "map sizes",
                "are missing",
                "give at least one, such as 1024",
            )
            .into());
        }
        let max = self.max_settings.unwrap_or(usize::MAX);
        let mut out = Vec::new();
        for entry in chosen {
            let listed = if self.headline {
                entry.headline
            } else {
                entry.settings
            };
            let of_entry = listed(&self.map_sizes, fit);
            out.extend(of_entry.into_iter().take(max));
        }
        Ok(out)
    }
}

/// Adds a stem to every setting.
///
/// It is the technique's name, with the settings if the technique has several. Presets come first
/// and use their own names. Duplicate stems get a number.
fn with_slugs(presets: &[NamedPreset], settings: &[TechniquePreset]) -> Vec<NamedSetting> {
    let mut out: Vec<NamedSetting> = Vec::new();
    for preset in presets {
        let technique = preset.preset.clone();
        out.push(NamedSetting {
            name: preset.name.clone(),
            settings: format!("{}, {}", technique.name(), technique.settings()),
            slug: unused_stem(&slug(&preset.name), &out),
            technique,
        });
    }
    for technique in settings {
        let of_technique = settings.iter().filter(|s| s.name() == technique.name());
        let stem = if of_technique.count() > 1 {
            format!("{}-{}", technique.name(), technique.settings())
        } else {
            technique.name().into()
        };
        out.push(NamedSetting {
            technique: technique.clone(),
            name: technique.name().to_owned(),
            settings: technique.settings(),
            slug: unused_stem(&slug(&stem), &out),
        });
    }
    out
}

/// Returns the stem, or if it exists, the stem with the first unused number from 2 on.
fn unused_stem(stem: &str, others: &[NamedSetting]) -> String {
    let mut out = stem.to_owned();
    let mut number = 2;
    while others.iter().any(|other| other.slug == out) {
        out = format!("{stem}-{number}");
        number += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_techniques::{Hard, ListedTechnique as _, MapTechnique, Pcf};

    #[test]
    fn presets_come_first_under_their_own_names() {
        let preset = |name: &str| NamedPreset {
            name: name.to_owned(),
            preset: TechniquePreset::from(MapTechnique::<Pcf>::default()),
        };
        let settings: [TechniquePreset; 1] =
            [TechniquePreset::from(MapTechnique::<Hard>::default())];
        let named = with_slugs(
            &[preset("Street"), preset("hard.toml"), preset("street")],
            &settings,
        );
        let slugs: Vec<&str> = named.iter().map(|setting| &setting.slug[..]).collect();
        assert_eq!(slugs, ["street", "hard.toml", "street-2", "hard"]);
        assert_eq!(named[0].name, "Street");
        let words = format!("pcf, {}", MapTechnique::<Pcf>::default().settings());
        assert_eq!(named[0].settings, words);
        assert_eq!(
            named[3].settings,
            MapTechnique::<Hard>::default().settings()
        );
    }
}
