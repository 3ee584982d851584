//! Light presets: a technique and the per-frame work that a renderer may skip.

use super::TechniquePreset;
#[cfg(feature = "presets")]
use umbrage_core::Invalid;

/// Update frequency of a light's maps and other images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Update {
    /// Every frame.
    #[default]
    EveryFrame,
    /// Redraw when the light or a caster has moved. Images stay valid while only the camera moves.
    WhenSceneChanges,
    /// Draw once: nothing that the images depend on moves.
    Once,
}

/// Per-frame work that a renderer may skip because a plan found its effect negligible.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct FrameRules {
    /// When the light's images are redrawn.
    pub update: Update,
    /// Skip casters whose bounding sphere appears narrower than this many pixels; 0 draws all.
    pub skip_casters_below_pixels: f32,
}

/// Technique of a light with the rules for its frames. The file is that of a [`TechniquePreset`]
/// with an additional table `[frame]`. Default rules are not written.
/// [`TechniquePreset::from_toml`] reads the same file and ignores that table.
///
/// ```
/// use umbrage_techniques::{FrameRules, Hard, LightPreset, MapTechnique, Update};
/// let file = "technique = 'hard'\n[frame]\nupdate = 'when_scene_changes'";
/// let preset = LightPreset::from_toml(file)?;
/// assert_eq!(preset.technique, MapTechnique::<Hard>::default().into());
/// assert_eq!(preset.frame.update, Update::WhenSceneChanges);
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LightPreset {
    /// The technique and its settings.
    pub technique: TechniquePreset,
    /// Work that may be skipped.
    pub frame: FrameRules,
}

/// Name of the rules' table in files.
#[cfg(feature = "presets")]
pub(super) const FRAME: &str = "frame";

#[cfg(feature = "presets")]
impl LightPreset {
    /// Returns the preset as TOML, which [`LightPreset::from_toml`] reads back without any loss.
    ///
    /// # Errors
    /// Errors if the technique's settings are not a TOML table. Those of the built-in techniques
    /// always are.
    pub fn to_toml(&self) -> Result<String, Invalid> {
        let technique = self.technique.to_toml()?;
        if self.frame == FrameRules::default() {
            return Ok(technique);
        }
        let rules = toml::to_string(&self.frame).map_err(|e| unreadable_preset(&e.to_string()))?;
        Ok(format!("{technique}\n[{FRAME}]\n{rules}"))
    }

    /// Reads a preset of a built-in technique from TOML, with or without rules.
    ///
    /// # Errors
    /// Errors if the text is not TOML, names no built-in technique, or has a field that is unknown
    /// to the technique or the rules.
    pub fn from_toml(text: &str) -> Result<Self, Invalid> {
        let technique = TechniquePreset::from_toml(text)?;
        let table: toml::Table =
            toml::from_str(text).map_err(|e| unreadable_preset(&e.to_string()))?;
        let frame = match table.get(FRAME) {
            Some(rules) => rules
                .clone()
                .try_into()
                .map_err(|e: toml::de::Error| unreadable_preset(&e.to_string()))?,
            None => FrameRules::default(),
        };
        let preset = Self { technique, frame };
        preset.validate()?;
        Ok(preset)
    }

    fn validate(&self) -> Result<(), Invalid> {
        let pixels = self.frame.skip_casters_below_pixels;
        if pixels >= 0.0 && pixels.is_finite() {
            return Ok(());
        }
        Err(unreadable_preset(&format!(
            "skip_casters_below_pixels is {pixels}"
        )))
    }
}

#[cfg(feature = "presets")]
fn unreadable_preset(why: &str) -> Invalid {
    Invalid::new(
        format!("preset's table `{FRAME}`"),
        why.trim_end().to_owned(),
        "use `update = \"every_frame\"`, `\"when_scene_changes\"` or `\"once\"`, and \
         `skip_casters_below_pixels`, pixels, 0 or more",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hard, MapFilter as _, MapTechnique, Pcf, ShadowMap};

    #[test]
    fn rules_come_back_from_their_file() {
        for frame in [
            FrameRules::default(),
            FrameRules {
                update: Update::Once,
                skip_casters_below_pixels: 1.5,
            },
        ] {
            for technique in TechniquePreset::defaults() {
                let preset = LightPreset { technique, frame };
                let file = preset.to_toml().expect("a table");
                assert_eq!(
                    LightPreset::from_toml(&file).expect("read"),
                    preset,
                    "{file}"
                );
                // Readers that ignore the rules still read the technique.
                let technique = TechniquePreset::from_toml(&file).expect("read");
                assert_eq!(technique, preset.technique);
            }
        }
    }

    #[test]
    fn rules_that_say_nothing_are_left_out() {
        let map = ShadowMap::default();
        let preset = LightPreset {
            technique: Hard {}.on(map).into(),
            frame: FrameRules::default(),
        };
        assert_eq!(preset.to_toml(), preset.technique.to_toml());
        let pcf = TechniquePreset::from(MapTechnique::<Pcf>::default())
            .to_toml()
            .expect("a table");
        let read = LightPreset::from_toml(&pcf).expect("read");
        assert_eq!(read.frame, FrameRules::default());
    }

    #[test]
    fn bad_rules_are_refused() {
        for rules in [
            "update = 'sometimes'",
            "skip_casters_below_pixels = -1.0",
            "skip_casters_below_pixels = nan",
            "updates = 'once'",
        ] {
            let file = format!("technique = 'hard'\n[frame]\n{rules}");
            assert!(LightPreset::from_toml(&file).is_err(), "{rules}");
        }
        assert!(LightPreset::from_toml("technique = 'hard'\nframe = 3").is_err());
    }
}
