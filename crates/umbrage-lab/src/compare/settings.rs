//! The settings to compare on a scene, with names for readers and files.

use super::options::{CompareOptions, NamedPreset, SceneInput};
use crate::{error::LabError, output::slug};
use glam::Vec3;
use umbrage_core::{Aabb, Fit, Invalid, Layout, Light, Mesh, ShadowTechnique as _};
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
    let tight = options.settings_for(Fit::Tight, sees_far(input)?)?;
    let all = with_fit(&tight, input.fit, options)?;
    Ok(with_slugs(&options.presets, &all))
}

/// Least ratio of the scene's farthest and the camera's nearest distance at which a sun's map
/// without cascades is too coarse near the eye.
const FAR: f32 = 1000.0;

/// Reports whether the first light is a sun, and the scene extends far beyond the camera's near
/// plane. Maps around all casters are too coarse even if the camera looks down.
fn sees_far(input: &SceneInput) -> Result<bool, Invalid> {
    let (camera, light) = input.camera_and_light()?;
    let has_perspective = camera.clip_from_view.z_axis.w != 0.0;
    if !has_perspective || !matches!(light, Light::Directional { .. }) {
        return Ok(false);
    }
    // The near plane has the depth 0, or 1 in reversed projections.
    let view_from_clip = camera.clip_from_view.inverse();
    let planes = [0.0, 1.0].map(|depth| view_from_clip.project_point3(Vec3::Z * depth).z.abs());
    let near = planes[0].min(planes[1]);
    let scene = &input.scene;
    let of_mesh = |mesh: &Mesh| Aabb::from_points(mesh.positions.iter().copied());
    let bounds: Vec<Aabb> = scene.meshes.iter().map(of_mesh).collect();
    let distances = scene.instances.iter().flat_map(|instance| {
        let corners = bounds
            .get(instance.mesh)
            .into_iter()
            .flat_map(Aabb::corners);
        corners.map(|p| {
            let world = instance.world_from_local.transform_point3(p);
            world.distance(camera.eye())
        })
    });
    Ok(distances.fold(0.0, f32::max) >= FAR * near)
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
        self.settings_for(fit, false)
    }

    /// Returns the technique settings to compare. `keeps_cascades` adds the first setting with
    /// cascades of each technique, if the greatest number of settings excludes all of them.
    fn settings_for(
        &self,
        fit: Fit,
        keeps_cascades: bool,
    ) -> Result<Vec<TechniquePreset>, LabError> {
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
            let cascades = of_entry.iter().position(has_cascades);
            let excluded = cascades.filter(|&i| keeps_cascades && i >= max);
            let excluded = excluded.map(|i| of_entry[i].clone());
            out.extend(of_entry.into_iter().take(max));
            out.extend(excluded);
        }
        Ok(out)
    }
}

/// Reports whether a setting has a map with cascades.
fn has_cascades(setting: &TechniquePreset) -> bool {
    let map = setting.map();
    map.is_some_and(|map| matches!(map.layout, Layout::Cascades(_)))
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
    use umbrage_core::Camera;
    use umbrage_techniques::{Hard, ListedTechnique as _, MapTechnique, Pcf};

    /// Quick comparisons leave out most settings, but no cascades where a sun sees far.
    #[test]
    fn cascades_are_compared_where_a_sun_sees_far() {
        let options = CompareOptions {
            techniques: vec!["none".into(), "hard".into(), "exact".into()],
            max_settings: Some(3),
            ..CompareOptions::default()
        };
        let sun = umbrage_scenes::by_argument("cubes").unwrap();
        let lamp = Light::Point {
            position: Vec3::Y,
            radius: 0.0,
        };
        let count = |near: f32, light: Light| {
            let mut scene = sun.clone();
            let size = scene.cameras[0].size;
            let [eye, target] = [Vec3::splat(5.0), Vec3::ZERO];
            let camera = Camera::perspective(eye, target, Vec3::Y, 0.7, [near, 100.0], size);
            scene.cameras[0] = camera.unwrap();
            scene.lights[0] = light;
            let all = settings_of(&SceneInput::new(scene, ""), &options).unwrap();
            let cascades = all.iter().filter(|s| has_cascades(&s.technique)).count();
            [all.len(), cascades]
        };
        let light = sun.lights[0];
        assert!(matches!(light, Light::Directional { .. }));
        let [few, no_cascades] = count(1.0, light);
        assert_eq!(no_cascades, 0);
        assert_eq!(count(1e-3, light), [few + 1, 1]);
        assert_eq!(count(1e-3, lamp), [few, 0]);
        // Without a limit, they are compared once.
        let all = CompareOptions {
            max_settings: None,
            ..options.clone()
        };
        let settings = [false, true].map(|keeps| all.settings_for(Fit::Tight, keeps).unwrap());
        assert!(settings[0].iter().any(has_cascades));
        assert_eq!(settings[0], settings[1]);
    }

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
