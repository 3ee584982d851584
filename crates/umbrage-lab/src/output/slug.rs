//! Names that fit into file names.

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
