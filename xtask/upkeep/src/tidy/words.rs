//! Limits on words in prose (whole-line comments, strings and Markdown), and on the form of
//! comments.

use super::files::SourceFile;

/// Words, and how often 100,000 lines of Rust and Markdown may have them.
const WORDS: [(&[&str], usize); 7] = [
    (
        &["play", "plays", "played", "playing", "player", "players"],
        8,
    ),
    (&["ask", "asks", "asked", "asking"], 20),
    (&["tell", "tells", "told"], 16),
    (&["lie", "lies", "lay"], 22),
    (&["beside"], 6),
    (&["none if", "none where"], 6),
    (&["anew"], 0),
];
/// Words that must not begin a documentation comment: use a noun phrase or a third-person verb.
const OPENERS: [&str; 8] = ["What", "How", "Where", "Which", "Of", "Its", "As", "By"];
/// The greatest width of a comment line, columns.
const MAX_WIDTH: usize = 100;
/// The share of comments that may break a rule of form.
const MAX_SHARE: f64 = 0.01;
/// This file lists the words.
const OWN_PATH: &str = "xtask/upkeep/src/tidy/words.rs";

/// What was counted over all files.
#[derive(Debug, Default)]
pub(super) struct Prose {
    /// Lines of Rust and Markdown.
    lines: usize,
    /// Places of each group of words, as `path:line`.
    words: [Vec<String>; WORDS.len()],
    /// Lines of comments, and the places of those that are too wide.
    comments: (usize, Vec<String>),
    /// Documentation comments, and the places of those that begin with an opener.
    docs: (usize, Vec<String>),
}

impl Prose {
    /// Counts the words and comments of a file.
    pub(super) fn add(&mut self, source: &SourceFile) {
        let is_rust = source.extension() == "rs";
        if source.path == OWN_PATH || !(is_rust || source.extension() == "md") {
            return;
        }
        let mut was_doc = false;
        for (i, line) in source.text.lines().enumerate() {
            let place = || format!("{}:{}", source.path, i + 1);
            self.lines += 1;
            let prose = if is_rust {
                prose_of(line)
            } else {
                line.to_owned()
            };
            let prose = prose.to_lowercase();
            for ((group, _), places) in WORDS.iter().zip(&mut self.words) {
                let count: usize = group.iter().map(|words| count(&prose, words)).sum();
                places.extend(std::iter::repeat_n(place(), count));
            }
            let text = line.trim_start();
            if is_rust && text.starts_with("//") {
                self.comments.0 += 1;
                // Rows of tables can't be wrapped.
                if line.chars().count() > MAX_WIDTH && !text.contains('|') {
                    self.comments.1.push(place());
                }
            }
            let doc = ["///", "//!"].iter().find_map(|m| text.strip_prefix(m));
            let doc = doc.filter(|_| is_rust);
            if let Some(doc) = doc.filter(|_| !was_doc) {
                self.docs.0 += 1;
                let first = doc.split_whitespace().next().unwrap_or("");
                if OPENERS.contains(&first) {
                    self.docs.1.push(place());
                }
            }
            was_doc = doc.is_some();
        }
    }

    /// Returns the limits that are exceeded, each with the first places.
    pub(super) fn faults(&self) -> Vec<String> {
        let mut out = Vec::new();
        for ((group, rate), places) in WORDS.iter().zip(&self.words) {
            let allowed = rate * self.lines / 100_000;
            let what = format!("the words `{}`", group.join("`, `"));
            out.extend(excess(&what, places, allowed));
        }
        let allowed = |count: usize| (MAX_SHARE * count as f64) as usize;
        let (count, places) = &self.comments;
        let what = format!("comments over {MAX_WIDTH} columns");
        out.extend(excess(&what, places, allowed(*count)));
        let (count, places) = &self.docs;
        let what = format!("documentation that begins with {}", OPENERS.join(", "));
        out.extend(excess(&what, places, allowed(*count)));
        out
    }
}

fn excess(what: &str, places: &[String], allowed: usize) -> Option<String> {
    let first: Vec<_> = places.iter().take(5).map(String::as_str).collect();
    (places.len() > allowed).then(|| {
        format!(
            "{what}: {} times, and {allowed} are allowed; reword {}",
            places.len(),
            first.join(", ")
        )
    })
}

/// Returns the comment or the string literals of a line of Rust.
fn prose_of(line: &str) -> String {
    if line.trim_start().starts_with("//") {
        return line.to_owned();
    }
    let strings = line.split('"').skip(1).step_by(2);
    strings.collect::<Vec<_>>().join(" ")
}

/// Returns how often words occur in a text, not as parts of longer words or of identifiers.
fn count(text: &str, words: &str) -> usize {
    let is_inner = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let places = text.match_indices(words);
    let whole = places.filter(|(at, _)| {
        let before = text[..*at].chars().next_back();
        let after = text[at + words.len()..].chars().next();
        !is_inner(before) && !is_inner(after)
    });
    whole.count()
}

#[cfg(test)]
mod tests {
    use super::{Prose, SourceFile};

    fn faults(path: &str, line: &str, times: usize) -> usize {
        let mut prose = Prose::default();
        prose.add(&SourceFile {
            path: path.to_owned(),
            text: format!("{line}\n").repeat(times),
        });
        prose.faults().len()
    }

    #[test]
    fn words_are_counted_in_prose_alone() {
        assert_eq!(faults("a.rs", "fn play() {}", 1), 0, "code");
        assert_eq!(faults("a.rs", "// It plays.", 1), 1);
        assert_eq!(faults("a.rs", "f(\"It plays.\");", 1), 1);
        assert_eq!(faults("a.md", "None if it plays.", 1), 2);
        assert_eq!(faults("a.md", "`None` if it displays play_time.", 1), 0);
        assert_eq!(faults("a.toml", "# It plays.", 1), 0);
    }

    #[test]
    fn a_few_are_allowed_over_many_lines() {
        let mut prose = Prose::default();
        let lines = format!("{}// asked\n", "x();\n".repeat(4_999));
        prose.add(&SourceFile {
            path: "a.rs".to_owned(),
            text: lines,
        });
        assert!(prose.faults().is_empty());
        prose.add(&SourceFile {
            path: "b.rs".to_owned(),
            text: "// asked\n".to_owned(),
        });
        assert_eq!(prose.faults().len(), 1);
    }

    #[test]
    fn comments_have_a_width_and_begin_well() {
        assert_eq!(faults("a.rs", &format!("// {}", "x".repeat(98)), 1), 1);
        assert_eq!(faults("a.rs", &format!("// {}", "x".repeat(97)), 1), 0);
        assert_eq!(faults("a.rs", "/// What it is.", 1), 1);
        assert_eq!(faults("a.rs", "/// Returns it.\n/// What is more.", 1), 0);
    }
}
