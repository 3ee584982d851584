//! Preprocessing of OBJ text: keeps checked statements that make a mesh, in a form that `tobj`
//! reads correctly.
//!
//! `tobj` 4.0 alone treats lines as faces and loses the first vertex after a byte order mark. It
//! fails on comments after faces, on continued lines, on a lone carriage return, on vertices of
//! which only some are coloured, and on names that aren't UTF-8. It overflows on indices far out of
//! range, and doesn't report the line of an error.

use super::parts::Looks;
use crate::{SceneError, error::Place};
use std::io::{self, BufRead, Read as _};
use std::path::Path;

/// Greatest length of a line, bytes. A face with a million corners fits, and a file without line
/// ends can't fill the memory.
const LONGEST_LINE: u64 = 16 << 20;
/// Greatest number of corners of a face. Cutting concave polygons takes quadratic time.
const MOST_CORNERS: usize = 4096;
/// Kinds of indices, in the order of a face's corner.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Checked statements, and the data withheld from `tobj`.
#[derive(Debug, Default)]
pub(super) struct CleanText {
    pub(super) statements: Vec<u8>,
    pub(super) faces: usize,
    pub(super) looks: Looks,
}

/// Reads a whole source. `unreadable` creates the error of a source that fails.
pub(super) fn clean(
    mut source: impl BufRead,
    path: &Path,
    unreadable: &dyn Fn(&io::Error) -> SceneError,
) -> Result<CleanText, SceneError> {
    let mut cleaner = Cleaner {
        path,
        line: 0,
        continued: String::new(),
        counts: [0; 3],
        greatest: [(0, 0); 3],
        clean: CleanText::default(),
    };
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let mut line = source.by_ref().take(LONGEST_LINE);
        let length = line.read_until(b'\n', &mut bytes);
        if length.map_err(|e| unreadable(&e))? == 0 {
            break;
        }
        if cleaner.line == 0 && bytes.starts_with(b"\xef\xbb\xbf") {
            bytes.drain(..3);
        }
        cleaner.lines(&bytes)?;
    }
    let rest = std::mem::take(&mut cleaner.continued);
    cleaner.statement(&rest)?;
    cleaner.check_greatest()?;
    Ok(cleaner.clean)
}

/// The state between two lines.
struct Cleaner<'a> {
    path: &'a Path,
    /// Line number, counted from 1.
    line: usize,
    /// A statement that continues in the next line.
    continued: String,
    /// Vertices, texture coordinates and normals so far.
    counts: [usize; 3],
    /// The greatest index of each so far, and its line.
    greatest: [(usize, usize); 3],
    clean: CleanText,
}

impl Cleaner<'_> {
    /// Cleans bytes up to a line feed. A lone carriage return ends a line, too.
    fn lines(&mut self, bytes: &[u8]) -> Result<(), SceneError> {
        let unusable = match bytes.len() as u64 {
            LONGEST_LINE => Some("is over 16 MiB long"),
            _ => bytes.contains(&0).then_some("is not text"),
        };
        let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        let bytes = bytes.strip_suffix(b"\r").unwrap_or(bytes);
        for line in bytes.split(|&b| b == b'\r') {
            self.line += 1;
            if let Some(why) = unusable {
                let help = "save the model as a Wavefront OBJ in ASCII or UTF-8";
                return Err(self.fault(why, help));
            }
            let text = String::from_utf8_lossy(line);
            let text = text.split('#').next().unwrap_or_default();
            match text.trim_end().strip_suffix('\\') {
                Some(part) => {
                    self.continued.push_str(part);
                    self.continued.push(' ');
                }
                None => {
                    let whole = std::mem::take(&mut self.continued) + text;
                    self.statement(&whole)?;
                }
            }
        }
        Ok(())
    }

    /// Keeps a statement that makes a mesh. Names, lines, points and curves make no triangles.
    fn statement(&mut self, text: &str) -> Result<(), SceneError> {
        let mut words = text.split_whitespace();
        let keyword = words.next().unwrap_or_default();
        let words: Vec<&str> = words.collect();
        // Withhold it: `tobj` would split the mesh at each material, and doesn't report the file of
        // its name.
        let name = || {
            let rest = text.trim().strip_prefix(keyword).unwrap_or_default();
            rest.trim().to_owned()
        };
        match keyword {
            "v" => {
                // A fourth and last number is a weight. More numbers are a colour.
                let used = if words.len() == 4 { 4 } else { 3 };
                let numbers = self.numbers(0, &words, used)?;
                let w = numbers.get(3).copied().unwrap_or(1.0);
                if let Some(bad) = numbers[..3].iter().find(|x| !(*x / w).is_finite()) {
                    let over = match w {
                        1.0 => String::new(),
                        w => format!(" over {w}"),
                    };
                    let why = format!("vertex holds {bad}{over}");
                    return Err(self.fault(why, "use finite numbers below 3.4e38"));
                }
                self.keep("v", &words[..used]);
            }
            "vt" => {
                let used = words.len().clamp(1, 2);
                self.numbers(1, &words, used)?;
                self.keep("vt", &[words[0], words.get(1).copied().unwrap_or("0")]);
            }
            "vn" => {
                self.numbers(2, &words, 3)?;
                self.keep("vn", &words[..3]);
            }
            "f" => self.face(&words)?,
            "usemtl" => self.clean.looks.runs.push((self.clean.faces, name())),
            "mtllib" => self.clean.looks.libraries.push(name()),
            _ => {}
        }
        Ok(())
    }

    /// Counts an element of a kind, and returns its first numbers.
    fn numbers(
        &mut self,
        kind: usize,
        words: &[&str],
        count: usize,
    ) -> Result<Vec<f32>, SceneError> {
        self.counts[kind] += 1;
        let what = KINDS[kind];
        if words.len() < count && words.iter().all(|word| word.parse::<f32>().is_ok()) {
            let why = format!("{what} has {} numbers of {count}", words.len());
            return Err(self.fault(why, "check that the file is complete"));
        }
        let parsed = words.iter().take(count).map(|word| {
            word.parse().map_err(|_| {
                let why = format!("{what} holds `{word}`, which is not a number");
                self.fault(why, "write numbers as 1.5 or 2e-3")
            })
        });
        parsed.collect()
    }

    fn face(&mut self, words: &[&str]) -> Result<(), SceneError> {
        words.iter().try_for_each(|word| self.corner(word))?;
        if words.len() > MOST_CORNERS {
            let why = format!("face has {} corners", words.len());
            let help = "export the model as triangles: a face may have at most 4,096 corners";
            return Err(self.fault(why, help));
        }
        // A face with fewer corners has no area and casts no shadow.
        if words.len() >= 3 {
            self.clean.faces += 1;
            self.keep("f", words);
        }
        Ok(())
    }

    /// Checks a corner. Negative indices count back from the latest. Positive ones may refer to
    /// later elements, and are checked at the end.
    fn corner(&mut self, word: &str) -> Result<(), SceneError> {
        const HELP: &str = "write corners as `v`, `v/vt`, `v//vn` or `v/vt/vn` with whole numbers";
        for (kind, part) in word.split('/').enumerate() {
            if kind >= KINDS.len() {
                return Err(self.fault(format!("face corner `{word}` has too many parts"), HELP));
            }
            if part.is_empty() && kind > 0 {
                continue;
            }
            let Ok(index) = part.parse::<i64>() else {
                return Err(self.fault(format!("face corner `{word}` is not an index"), HELP));
            };
            let (size, count) = (index.unsigned_abs() as usize, self.counts[kind]);
            if index > 0 {
                if size > self.greatest[kind].0 {
                    self.greatest[kind] = (size, self.line);
                }
            } else if index == 0 || size > count {
                let kind = KINDS[kind];
                let why = format!("face names {kind} {index}, but there are {count} before it");
                return Err(self.fault(why, "use indices from 1, or from -1 backwards"));
            }
        }
        Ok(())
    }

    fn check_greatest(&mut self) -> Result<(), SceneError> {
        for ((kind, (index, line)), count) in KINDS.iter().zip(self.greatest).zip(self.counts) {
            if index > count {
                self.line = line;
                let why = format!("face names {kind} {index}, but the file has {count}");
                return Err(self.fault(why, "check that the file is complete"));
            }
        }
        Ok(())
    }

    fn fault(&self, why: impl Into<String>, help: &str) -> SceneError {
        SceneError::Fault {
            place: Place {
                file: self.path.display().to_string(),
                line: Some(self.line),
                key: None,
            },
            why: why.into(),
            help: help.to_owned(),
        }
    }

    fn keep(&mut self, keyword: &str, words: &[&str]) {
        let out = &mut self.clean.statements;
        out.extend_from_slice(keyword.as_bytes());
        for word in words {
            out.push(b' ');
            out.extend_from_slice(word.as_bytes());
        }
        out.push(b'\n');
    }
}
