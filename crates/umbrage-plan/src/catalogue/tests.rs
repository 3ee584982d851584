//! Tests that the catalogue is complete.

use super::*;
use std::collections::HashSet;
use umbrage_core::{Geometry, ShadowTechnique as _, View, glam::Vec3};
use umbrage_cpu::Cpu;
use umbrage_techniques::{MapTechnique, Pcss, ShadowMap};

#[test]
fn names_are_unique_and_select_entries() {
    let catalogue = Catalogue::built_in();
    let names: HashSet<_> = catalogue.names().into_iter().collect();
    assert_eq!(names.len(), catalogue.all().len());
    assert!(
        catalogue
            .clone()
            .with(CatalogueEntry::for_technique::<MapTechnique<Pcss>>())
            .is_err()
    );
    let selected = catalogue.select(&["pcf".to_owned(), "none".to_owned()]);
    let selected: Vec<_> = selected
        .unwrap()
        .iter()
        .map(|entry| entry.technique.name)
        .collect();
    assert_eq!(selected, ["none", "pcf"]);
    let unknown = catalogue.select(&["pfc".to_owned()]).unwrap_err();
    assert!(unknown.to_string().contains("pcf_hardware"), "{unknown}");
}

/// Resumed runs compare their options as text.
#[test]
fn lists_show_names_alone() {
    let shown = format!("{:?}", Catalogue::built_in());
    assert!(shown.starts_with("Catalogue([none, hard, "), "{shown}");
}

#[test]
fn every_setting_of_an_entry_is_of_its_technique() {
    let lamp = Light::Disc {
        center: Vec3::Y,
        normal: -Vec3::Y,
        radius: 0.1,
    };
    let map = ShadowMap::default();
    for entry in all() {
        let settings = [
            (entry.settings)(&[64, 128], Fit::Tight),
            (entry.exhaustive)(64),
        ]
        .concat();
        assert!(
            settings.iter().all(|t| t.name() == entry.technique.name),
            "{}",
            entry.technique.name
        );
        let compared = (entry.settings)(&[64], Fit::Tight);
        assert!(
            !compared.is_empty() && settings.len() > compared.len(),
            "{}",
            entry.technique.name
        );
        assert!(
            !(entry.candidates)(map, &lamp).is_empty(),
            "{} is no candidate",
            entry.technique.name
        );
    }
}

/// A technique without a kernel entry would silently cost one tap.
#[test]
fn kernels_of_built_in_techniques_are_known() {
    // These look up the result at the receiver's own pixel: one tap.
    const ONE_TAP: [&str; 2] = ["planar", "volumes"];
    let scene = umbrage_scenes::by_argument("cubes").expect("built in");
    let geometry = Geometry::bake(&scene).expect("valid");
    let receivers = Cpu::new().receivers(&scene.cameras[0], &geometry);
    let receivers = receivers.expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry).with_receivers(&receivers);
    for entry in all() {
        let name = entry.technique.name;
        let recipe = (entry.technique.preset)().recipe(&view);
        let kernel = recipe.expect("serves the sun").receive.kernel;
        let is_known = all().iter().any(|entry| (entry.kernel)(&*kernel).is_some());
        assert_eq!(is_known, !ONE_TAP.contains(&name), "{name}");
    }
}
