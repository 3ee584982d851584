//! What the panel changes.

use crate::scene::Lamp;
use std::sync::Arc;
use umbrage::{
    Cascades, Fit, Invalid, Layout, ShadowTechnique,
    techniques::{Bias, ShadowMap, TechniqueEntry, TechniquePreset},
};

/// How far from the camera the sun's shadows reach, metres.
const SHADOW_RANGE: f32 = 70.0;

/// How the picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The technique of all lights, with the settings that it alone has.
    pub preset: TechniquePreset,
    pub bias: Bias,
    /// Side of the sun's maps, texels. Those of lamps have half of it.
    pub map_size: u32,
    /// The sun's maps; 1 for a single one.
    pub cascades: u32,
    /// Whether the sun is a lamp with perspective.
    pub sun_perspective: bool,
    pub deferred: bool,
    /// Whether things move.
    pub moving: bool,
}

impl Settings {
    pub fn new(technique: &TechniqueEntry) -> Self {
        let preset = (technique.preset)();
        Self {
            bias: own_bias(&preset),
            preset,
            map_size: 1024,
            cascades: 4,
            sun_perspective: false,
            deferred: false,
            moving: true,
        }
    }

    /// Takes a technique's default settings, with the bias that it is made for.
    pub fn choose(&mut self, technique: &TechniqueEntry) {
        self.preset = (technique.preset)();
        self.bias = own_bias(&self.preset);
    }

    /// Takes a preset, as `cargo xtask plan` writes it and the viewer copies it: technique, bias, side of the map, and how many cascades.
    /// What does not come from it is where maps lie: this program's stand still while the camera moves.
    ///
    /// # Errors
    /// Errors if the text is no preset.
    pub fn paste(&mut self, text: &str) -> Result<(), Invalid> {
        self.preset = TechniquePreset::from_toml(text)?;
        self.bias = own_bias(&self.preset);
        if let Some(map) = self.preset.map() {
            self.map_size = map.size;
            self.cascades = match map.layout {
                Layout::Cascades(cascades) => cascades.count,
                _ => 1,
            };
        }
        Ok(())
    }

    /// Returns these settings' technique for a lamp.
    pub fn technique(&self, lamp: &Lamp) -> Arc<dyn ShadowTechnique> {
        self.on_maps(&self.preset, self.bias, lamp)
    }

    /// Returns a technique of the list as these settings would play it.
    pub fn candidate(&self, technique: &TechniqueEntry, lamp: &Lamp) -> Arc<dyn ShadowTechnique> {
        let preset = (technique.preset)();
        self.on_maps(&preset, own_bias(&preset), lamp)
    }

    fn on_maps(
        &self,
        preset: &TechniquePreset,
        bias: Bias,
        lamp: &Lamp,
    ) -> Arc<dyn ShadowTechnique> {
        let Some(own) = preset.map() else {
            return preset.technique();
        };
        let is_directional = lamp.light.position().is_none();
        let layout = if is_directional && self.cascades > 1 {
            Layout::Cascades(Cascades {
                count: self.cascades,
                blend: 4.0,
                ..Cascades::default()
            })
        } else {
            Layout::Auto
        };
        let map = ShadowMap {
            size: (self.map_size / lamp.map_divisor).max(1),
            // Maps that stand still while the camera moves.
            fit: Fit::Stable {
                range: SHADOW_RANGE,
            },
            layout,
            bias,
            ..*own
        };
        preset.with_map(map).technique()
    }
}

fn own_bias(preset: &TechniquePreset) -> Bias {
    preset.map().map_or(Bias::NONE, |map| map.bias)
}
