//! Settings of one of the two sides.

use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage::{
    Cascades, Fit, Layout, Light, ShadowTechnique,
    techniques::{self, FrameRules, LightPreset, ShadowMap, TechniqueEntry, TechniquePreset},
};

/// Names of the two sides.
pub(crate) const SIDES: [&str; 2] = ["left", "right"];

/// Extent of maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum FitKind {
    /// Around all casters.
    Tight,
    /// Around the whole scene.
    Whole,
    /// Around the camera's view, in steps of whole texels.
    Stable,
    /// Around the camera, in steps of whole texels.
    AroundCamera,
}

impl FitKind {
    pub(crate) const ALL: [Self; 4] = [Self::Tight, Self::Whole, Self::Stable, Self::AroundCamera];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Tight => "tight",
            Self::Whole => "whole scene",
            Self::Stable => "stable",
            Self::AroundCamera => "around the camera",
        }
    }
}

/// A technique with all its settings, for all lights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SideSettings {
    /// The technique, with its map if it has one.
    #[serde(with = "preset_text")]
    pub preset: TechniquePreset,
    pub fit: FitKind,
    /// Range around the camera, metres, for fits that need it.
    pub range: f32,
    /// Number of maps of a directional light; 1 for a single one.
    pub cascades: u32,
}

/// Saves presets as texts of preset files.
mod preset_text {
    use super::entry;
    use serde::{Deserialize as _, Deserializer, Serializer, ser::Error as _};
    use umbrage::techniques::TechniquePreset;

    pub(super) fn serialize<S: Serializer>(
        preset: &TechniquePreset,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let text = preset.to_toml().map_err(S::Error::custom)?;
        serializer.serialize_str(&text)
    }

    /// Reads a preset. An unknown one, such as that of a newer version, becomes `exact`.
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<TechniquePreset, D::Error> {
        let text = String::deserialize(deserializer)?;
        let read = TechniquePreset::from_toml(&text);
        Ok(read.unwrap_or_else(|_| (entry("exact").preset)()))
    }
}

impl SideSettings {
    /// Returns a technique's default settings. `range` is the camera's range of view, metres.
    pub(crate) fn new(entry: &TechniqueEntry, range: f32) -> Self {
        Self {
            preset: (entry.preset)(),
            fit: FitKind::Tight,
            range,
            cascades: 1,
        }
    }

    /// Selects another technique, with its default settings on maps of the same size.
    pub(crate) fn choose(&mut self, entry: &TechniqueEntry) {
        let side = self.preset.map().map(|map| map.size);
        self.preset = (entry.preset)();
        if let (Some(side), Some(own)) = (side, self.preset.map().copied()) {
            self.preset = self.preset.with_map(ShadowMap { size: side, ..own });
        }
    }

    /// Returns the technique for a light. Only directional lights have cascades.
    pub(crate) fn technique(&self, light: &Light) -> Arc<dyn ShadowTechnique> {
        self.preset_for(light).technique()
    }

    /// Returns the settings for a light as a program would load them.
    pub(crate) fn preset_for(&self, light: &Light) -> TechniquePreset {
        let Some(own) = self.preset.map() else {
            return self.preset.clone();
        };
        // Use cascades for directional lights. Those of a plan or a file keep their other settings.
        let cascades = match own.layout {
            Layout::Cascades(cascades) => cascades,
            _ => Cascades::default(),
        };
        let is_directional = light.position().is_none();
        let layout = match own.layout {
            _ if is_directional && self.cascades > 1 => Layout::Cascades(Cascades {
                count: self.cascades,
                ..cascades
            }),
            Layout::Cascades(_) => Layout::Auto,
            other => other,
        };
        let fit = match self.fit {
            FitKind::Tight => Fit::Tight,
            FitKind::Whole => Fit::Whole,
            FitKind::Stable => Fit::Stable { range: self.range },
            FitKind::AroundCamera => Fit::AroundCamera { range: self.range },
        };
        self.preset.with_map(ShadowMap {
            fit,
            layout,
            ..*own
        })
    }

    /// Adopts the settings of a preset.
    pub(crate) fn take(&mut self, preset: &TechniquePreset) {
        self.preset = preset.clone();
        let Some(map) = preset.map() else {
            return;
        };
        self.cascades = 1;
        if let Layout::Cascades(cascades) = map.layout {
            self.cascades = cascades.count;
        }
        self.fit = FitKind::Tight;
        match map.fit {
            Fit::Whole => self.fit = FitKind::Whole,
            Fit::Stable { range } => {
                self.fit = FitKind::Stable;
                self.range = range;
            }
            Fit::AroundCamera { range } => {
                self.fit = FitKind::AroundCamera;
                self.range = range;
            }
            Fit::Tight | Fit::Manual { .. } => {}
        }
    }

    /// Returns the text of a preset file for a light.
    pub(crate) fn preset_text(&self, light: &Light) -> anyhow::Result<String> {
        let preset = LightPreset {
            technique: self.preset_for(light),
            frame: FrameRules::default(),
        };
        Ok(preset.to_toml()?)
    }

    /// Returns a short label of the technique and its settings.
    pub(crate) fn label(&self) -> String {
        let name = self.preset.name();
        let settings = self.preset.settings();
        if settings.is_empty() {
            return name.to_owned();
        }
        format!("{name} ({settings})")
    }
}

/// Returns a technique's entry in the list.
///
/// # Panics
/// Panics if no technique has that name.
pub(crate) fn entry(name: &str) -> &'static TechniqueEntry {
    techniques::find(name).unwrap_or_else(|| panic!("`{name}` is not a technique"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::glam::Vec3;

    #[test]
    fn what_is_taken_is_what_is_shown() {
        let cascades = Cascades {
            count: 3,
            nearest: 7.0,
            blend: 4.0,
            ..Cascades::default()
        };
        let own = (entry("pcf").preset)();
        let preset = own.with_map(ShadowMap {
            layout: Layout::Cascades(cascades),
            fit: Fit::Stable { range: 30.0 },
            ..*own.map().expect("a map")
        });
        let mut side = SideSettings::new(entry("hard"), 1.0);
        side.take(&preset);
        let sun = Light::Directional {
            direction: Vec3::NEG_Y,
            angular_diameter: 0.0,
        };
        assert_eq!(side.preset_for(&sun), preset);
        // Only directional lights have cascades.
        let lamp = Light::Point {
            position: Vec3::Y,
            radius: 0.0,
        };
        let of_lamp = side.preset_for(&lamp);
        assert_eq!(of_lamp.map().expect("a map").layout, Layout::Auto);
    }
}
