//! Names of techniques and settings that fit into file names.

use std::sync::Arc;
use umbrage_core::ShadowTechnique;

/// A technique setting with a file name's stem of its own.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    pub(super) technique: Arc<dyn ShadowTechnique>,
    pub(super) slug: String,
}

/// Gives every setting a stem: the technique's name, and its settings where there are several; the same again gets a
/// number.
pub(super) fn with_slugs(settings: &[Arc<dyn ShadowTechnique>]) -> Vec<Setting> {
    let mut out: Vec<Setting> = Vec::new();
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
        out.push(Setting {
            technique: technique.clone(),
            slug,
        });
    }
    out
}

/// Letters, digits, dots, underscores and single dashes; never empty, never hidden. Small letters alone, as some file systems
/// don't tell capital ones apart.
pub(crate) fn slug(text: &str) -> String {
    let keep = |c: char| {
        if c.is_alphanumeric() || c == '.' || c == '_' {
            c
        } else {
            '-'
        }
    };
    let words: String = text.to_lowercase().chars().map(keep).collect();
    let joined = words
        .split('-')
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join("-");
    // Windows drops dots at the end.
    let visible = joined
        .trim_start_matches(['.', '-'])
        .trim_end_matches(['.', '-']);
    if visible.is_empty() {
        return "unnamed".to_owned();
    }
    // Windows has devices of these names, whatever comes after a dot.
    let stem = visible.split('.').next().unwrap_or_default();
    let numbered = ["com", "lpt"].iter().any(|device| {
        stem.strip_prefix(device)
            .is_some_and(|rest| rest.len() == 1 && rest.as_bytes()[0].is_ascii_digit())
    });
    if numbered || ["con", "prn", "aux", "nul"].contains(&stem) {
        format!("_{visible}")
    } else {
        visible.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::slug;

    #[test]
    fn slugs_are_safe_file_names() {
        assert_eq!(
            slug("pcf-3x3, 1024, slope .05/.005"),
            "pcf-3x3-1024-slope-.05-.005"
        );
        assert_eq!(slug("../../etc/passwd"), "etc-passwd");
        assert_eq!(slug("  "), "unnamed");
        assert_eq!(slug("Sun & Moon"), "sun-moon");
        assert_eq!(slug("ÄRGER..."), "ärger");
        assert_eq!(
            ["con", "NUL.txt", "com7", "com10", "console"].map(slug),
            ["_con", "_nul.txt", "_com7", "com10", "console"]
        );
    }
}
