//! No technique is forgotten, and files bring back what was written.

use crate::{
    Preset,
    shadow_map::{Bias, Border, MapFormat, ShadowMap},
    techniques::pcss::Pcss,
};
use umbrage_core::{Fit, glam::Vec3};

#[test]
fn the_catalogue_and_the_presets_hold_the_same_techniques() {
    let mut presets: Vec<_> = Preset::defaults()
        .iter()
        .map(|p| p.technique().name())
        .collect();
    let mut catalogue: Vec<_> = crate::all().iter().map(|entry| entry.name).collect();
    presets.sort_unstable();
    catalogue.sort_unstable();
    assert_eq!(presets, catalogue);
}

#[test]
fn a_file_that_only_names_a_technique_means_its_defaults() {
    for preset in Preset::defaults() {
        let name = preset.technique().name();
        assert_eq!(
            Preset::from_toml(&format!("technique = \"{name}\"")).unwrap(),
            preset
        );
    }
}

/// Numbers without a short decimal form, a nested table, and no field at its default.
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
    for preset in Preset::defaults()
        .into_iter()
        .flat_map(|p| [p, p.with_map(map)])
    {
        let text = preset.to_toml().unwrap();
        assert_eq!(Preset::from_toml(&text).unwrap(), preset, "{text}");
    }
}

#[test]
fn maps_can_be_exchanged_wherever_there_is_one() {
    let map = ShadowMap {
        size: 77,
        ..ShadowMap::default()
    };
    for preset in Preset::defaults() {
        let changed = preset.with_map(map);
        assert_eq!(changed.map().copied(), preset.map().map(|_| map));
        assert_eq!(changed.technique().name(), preset.technique().name());
    }
    assert_eq!(
        Preset::from(Pcss::default()).map(),
        Some(&Pcss::default().map)
    );
}

#[test]
fn wrong_files_are_told_what_to_write() {
    for text in [
        "technique = 'pfc'",
        "radius = 1",
        "technique = 'pcf'\nradios = 2",
        "technique = 'hard'\nmap = 3",
        "=",
    ] {
        let error = Preset::from_toml(text).unwrap_err().to_string();
        assert!(error.contains("pcf_hardware"), "{error}");
    }
}
