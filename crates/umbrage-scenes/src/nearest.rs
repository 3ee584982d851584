//! Suggestions for misspelled words.

/// Returns the candidates that are similar to `word`, most likely first: those few edits away, or
/// with the same start.
pub(crate) fn nearest<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Vec<&'a str> {
    let word = word.to_lowercase();
    // Up to a third of the letters may differ, and at least one.
    let reach = (word.chars().count() / 3).max(1);
    let mut near: Vec<(usize, &str)> = candidates
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(&word, c), c))
        .map(|(edits, c)| {
            if word.len() > 2 && (c.contains(&word) || word.contains(c)) {
                (edits.min(reach), c)
            } else {
                (edits, c)
            }
        })
        .filter(|&(edits, _)| edits <= reach)
        .collect();
    near.sort_by_key(|&(edits, _)| edits);
    near.into_iter().map(|(_, c)| c).take(3).collect()
}

/// Formats words as a list: `` `a`, `b` or `c` ``.
pub(crate) fn list_words(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|w| format!("`{w}`")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_understood() {
        let keys = [
            "eye",
            "target",
            "up",
            "fov_y_degrees",
            "size",
            "near",
            "far",
        ];
        assert_eq!(nearest("tagret", keys), ["target"]);
        assert_eq!(nearest("fov", keys), ["fov_y_degrees"]);
        assert_eq!(nearest("EYE", keys), ["eye"]);
        assert_eq!(nearest("colour", keys), [""; 0]);
    }

    #[test]
    fn lists_read_well() {
        assert_eq!(list_words(&["a"]), "`a`");
        assert_eq!(list_words(&["a", "b", "c"]), "`a`, `b` or `c`");
    }
}
