//! Names for files.

/// Returns a text as a file name of lowercase letters, digits, dots, underscores and single dashes.
/// Never empty, never hidden. Lowercase, as some file systems ignore case.
pub(crate) fn slug(text: &str) -> String {
    let lowercase = text.to_lowercase();
    let words: Vec<&str> = lowercase
        .split(|c: char| !c.is_alphanumeric() && c != '.' && c != '_')
        .filter(|word| !word.is_empty())
        .collect();
    let joined = words.join("-");
    // Trim dots at the end, which Windows drops.
    let visible = joined
        .trim_start_matches(['.', '-'])
        .trim_end_matches(['.', '-']);
    if visible.is_empty() {
        return "unnamed".to_owned();
    }
    // Avoid the names of Windows devices, which are reserved with any suffix.
    let stem = visible.split('.').next().unwrap_or_default();
    if is_device(stem) {
        format!("_{visible}")
    } else {
        visible.to_owned()
    }
}

/// Reports whether a name is reserved for a device on Windows: CON, PRN, AUX, NUL, COM0 to COM9,
/// LPT0 to LPT9.
fn is_device(stem: &str) -> bool {
    let number = stem
        .strip_prefix("com")
        .or_else(|| stem.strip_prefix("lpt"));
    let is_port = number.is_some_and(|rest| rest.len() == 1 && rest.as_bytes()[0].is_ascii_digit());
    is_port || ["con", "prn", "aux", "nul"].contains(&stem)
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
