//! Tests that the registry is complete and that presets survive a round trip through files.

use super::*;
use crate::MapTechnique;
use crate::shadow_map::{Bias, Border, MapFormat, ShadowMap};
use umbrage_core::{Fit, glam::Vec3};

#[test]
fn a_file_that_only_names_a_technique_means_its_defaults() {
    for preset in TechniquePreset::defaults() {
        let name = preset.technique().name();
        assert_eq!(
            TechniquePreset::from_toml(&format!("technique = \"{name}\"")).unwrap(),
            preset
        );
    }
}

/// The numbers have no short decimal form, a table is nested, and no field has its default value.
#[test]
fn every_preset_survives_a_file() {
    let extents = umbrage_core::Extents {
        left: -1.1,
        right: 2.3,
        bottom: -0.7,
        top: 0.3,
        near: 0.013,
        far: 77.7,
    };
    let fit = Fit::Manual {
        eye: Vec3::new(1.0 / 3.0, 2.1, -1e-7),
        extents,
    };
    let bias = Bias {
        receiver_plane: 0.1 / 3.0,
        ..Bias::normal_offset(1.3)
    };
    let map = ShadowMap {
        size: 192,
        fit,
        bias,
        format: MapFormat::Depth16,
        border: Border::Clamp,
        ..Default::default()
    };
    for preset in TechniquePreset::defaults()
        .into_iter()
        .flat_map(|p| [p.with_map(map), p])
    {
        let text = preset.to_toml().unwrap();
        assert_eq!(TechniquePreset::from_toml(&text).unwrap(), preset, "{text}");
    }
}

#[test]
fn cascades_are_written_as_they_are_spoken_of() {
    let text = "technique = 'hard'
[map]
fit = { stable = { range = 150.0 } }
layout = { cascades = { count = 3, split = { given = [5.0, 20.5, 150.0] }, blend = 12.0 } }
";
    let preset = TechniquePreset::from_toml(text).unwrap();
    let written = preset.to_toml().unwrap();
    assert_eq!(TechniquePreset::from_toml(&written).unwrap(), preset);
    let settings = preset.settings();
    assert!(
        settings.contains("stable fit to 150 m, 3 cascades to 5, 20.5, 150 m blend 12"),
        "{settings}"
    );
    for (layout, word) in [
        (
            "{ cascades = { count = 2, split = { given = [5.0, 2.0] } } }",
            "rising",
        ),
        ("{ cascades = { cuont = 2 } }", "cuont"),
    ] {
        let text = format!("technique = 'hard'\n[map]\nlayout = {layout}");
        let error = TechniquePreset::from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn maps_can_be_exchanged_wherever_there_is_one() {
    let map = ShadowMap {
        size: 77,
        ..ShadowMap::default()
    };
    for preset in TechniquePreset::defaults() {
        let changed = preset.with_map(map);
        assert_eq!(changed.map().copied(), preset.map().map(|_| map));
        assert_eq!(changed.technique().name(), preset.technique().name());
    }
    assert_eq!(
        TechniquePreset::from(MapTechnique::<Pcss>::default()).map(),
        Some(&MapTechnique::<Pcss>::default().map)
    );
}

#[test]
fn wrong_files_are_refused_with_what_to_write() {
    for text in [
        "technique = 'pfc'",
        "radius = 1",
        "technique = 'pcf'\nradios = 2",
        "technique = 'hard'\nmap = 3",
        "=",
    ] {
        let error = TechniquePreset::from_toml(text).unwrap_err().to_string();
        assert!(error.contains("pcf_hardware"), "{error}");
    }
}

/// Older preset files stay readable, and the written text does not change.
#[test]
fn the_text_of_presets_stays() {
    let text = TechniquePreset::from(MapTechnique::<Pcf>::default())
        .to_toml()
        .unwrap();
    assert!(
        text.starts_with("technique = \"pcf\"\nradius = 1\n\n[map]\nsize = 1024\n"),
        "{text}"
    );
    let unrolled = "technique = \"pcf\"\nradius = 2\nunrolled = true\n\n[map]\n";
    let preset = TechniquePreset::from_toml(unrolled).unwrap();
    assert!(preset.to_toml().unwrap().starts_with(unrolled));
}
