//! Names of techniques and settings that fit into file names.

use crate::output::slug;
use std::sync::Arc;
use umbrage_core::ShadowTechnique;

/// A technique setting with a file name's stem of its own.
#[derive(Clone, Debug)]
pub(super) struct NamedSetting {
    pub(super) technique: Arc<dyn ShadowTechnique>,
    pub(super) slug: String,
}

/// Gives every setting a stem: the technique's name, with the settings where the technique has several. Where two stems are
/// the same, later ones get a number.
pub(super) fn with_slugs(settings: &[Arc<dyn ShadowTechnique>]) -> Vec<NamedSetting> {
    let mut out: Vec<NamedSetting> = Vec::new();
    for technique in settings {
        let of_technique = settings.iter().filter(|s| s.name() == technique.name());
        let stem = if of_technique.count() > 1 {
            format!("{}-{}", technique.name(), technique.settings())
        } else {
            technique.name().into()
        };
        out.push(NamedSetting {
            technique: technique.clone(),
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
