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

/// Gives every setting a stem: the technique's name, and its settings where there are several; the same again gets a
/// number.
pub(super) fn with_slugs(settings: &[Arc<dyn ShadowTechnique>]) -> Vec<NamedSetting> {
    let mut out: Vec<NamedSetting> = Vec::new();
    for technique in settings {
        let several = settings
            .iter()
            .filter(|s| s.name() == technique.name())
            .count()
            > 1;
        let stem = if several {
            format!("{}-{}", technique.name(), technique.settings())
        } else {
            technique.name().into()
        };
        let stem = slug(&stem);
        let taken = |s: &str| out.iter().any(|o| o.slug == s);
        let numbered = (2..).map(|n| format!("{stem}-{n}"));
        let slug = std::iter::once(stem.clone())
            .chain(numbered)
            .find(|s| !taken(s))
            .unwrap_or(stem);
        out.push(NamedSetting {
            technique: technique.clone(),
            slug,
        });
    }
    out
}
