//! Names of settings, for people and for files.

use super::NamedPreset;
use crate::output::slug;
use umbrage_core::ShadowTechnique as _;
use umbrage_techniques::TechniquePreset;

/// A technique setting with a file name's stem of its own.
#[derive(Clone, Debug)]
pub(super) struct NamedSetting {
    pub(super) technique: TechniquePreset,
    /// The technique's name, or the preset's.
    pub(super) name: String,
    /// The settings; of a preset the technique, then its settings.
    pub(super) settings: String,
    pub(super) slug: String,
}

/// Gives every setting a stem: the technique's name, with the settings where the technique has several; presets, which come first,
/// their own names. Where two stems are the same, later ones get a number.
pub(super) fn with_slugs(
    presets: &[NamedPreset],
    settings: &[TechniquePreset],
) -> Vec<NamedSetting> {
    let mut out: Vec<NamedSetting> = Vec::new();
    for preset in presets {
        let technique = preset.preset.clone();
        out.push(NamedSetting {
            name: preset.name.clone(),
            settings: format!("{}, {}", technique.name(), technique.settings()),
            slug: unused(&slug(&preset.name), &out),
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
            slug: unused(&slug(&stem), &out),
        });
    }
    out
}

/// Returns the stem, with the first number from 2 on that makes it different from all others if it isn't.
fn unused(stem: &str, others: &[NamedSetting]) -> String {
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
