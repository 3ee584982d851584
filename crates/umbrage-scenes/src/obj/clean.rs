//! Preprocessing of OBJ text: keeps checked statements that make a mesh, in a form that `tobj`
//! reads correctly.
//!
//! `tobj` 4.0 alone treats lines as faces and loses the first vertex after a byte order mark. It
//! fails on comments after faces, on continued lines, on a lone carriage return, on vertices of
//! which only some are coloured, and on names that aren't UTF-8. It overflows on indices far out of
//! range, and doesn't report the line of an error.

use super::parts::Looks;
use crate::{SceneError, error::Place};
use std::collections::{BTreeMap, HashSet};
use std::io::{self, BufRead, Read as _};
use std::path::Path;

/// Greatest length of a line, bytes. A face with a million corners fits, and a file without line
/// ends can't fill the memory.
const LONGEST_LINE: u64 = 16 << 20;
/// Greatest number of corners of a face. Cutting concave polygons takes quadratic time.
const MOST_CORNERS: usize = 4096;
/// Greatest number of ignored keywords that are listed.
const MOST_NAMES: usize = 20;
/// Kinds of indices, in the order of a face's corner.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Checked statements, and the data withheld from `tobj`.
#[derive(Debug, Default)]
pub(super) struct CleanText {
    pub(super) statements: Vec<u8>,
    pub(super) faces: usize,
    pub(super) looks: Looks,
    /// Ignored contents of the file, one line each.
    pub(super) notices: Vec<String>,
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
        unusable: Vec::new(),
        dropped: [None, None, None],
        ignored: BTreeMap::new(),
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
    cleaner.check_vertices()?;
    cleaner.drop_attributes();
    cleaner.list_ignored();
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
    /// Vertices that no face may use: the number, counted from 1, the line, and the reason.
    unusable: Vec<(usize, usize, String)>,
    /// The reason why the texture coordinates or the normals are dropped, if they are.
    dropped: [Option<String>; 3],
    /// Ignored keywords, and their numbers of statements.
    ignored: BTreeMap<String, usize>,
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
            // Names of materials may end in a backslash.
            let is_name = self.continued.is_empty() && text.trim_start().starts_with("usemtl");
            let continued = text.trim_end().strip_suffix('\\');
            match continued.filter(|_| !is_name) {
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

    /// Keeps a statement that makes a mesh, and counts others. Names are ignored silently, since
    /// they change nothing.
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
                    self.unusable.push((self.counts[0], self.line, why));
                    self.keep("v", &["0", "0", "0"]);
                } else {
                    self.keep("v", &words[..used]);
                }
            }
            "vt" => {
                let used = words.len().clamp(1, 2);
                match self.numbers(1, &words, used) {
                    Ok(_) => self.keep("vt", &[words[0], words.get(1).copied().unwrap_or("0")]),
                    Err(fault) => self.drop_kind(1, &fault),
                }
            }
            "vn" => match self.numbers(2, &words, 3) {
                Ok(_) => self.keep("vn", &words[..3]),
                Err(fault) => self.drop_kind(2, &fault),
            },
            // `fo` is the obsolete form of `f`.
            "f" | "fo" => self.face(&words)?,
            "usemtl" => self.clean.looks.runs.push((self.clean.faces, name())),
            "mtllib" => self.clean.looks.libraries.push(name()),
            // Names, and the end of a smoothing group.
            "" | "o" | "g" => {}
            "s" if words == ["off"] || words == ["0"] => {}
            _ => *self.ignored.entry(keyword.to_owned()).or_default() += 1,
        }
        Ok(())
    }

    /// Drops an attribute of all corners. The first reason counts.
    fn drop_kind(&mut self, kind: usize, fault: &SceneError) {
        let why = match fault {
            SceneError::Fault { place, why, .. } => {
                format!("line {}: {why}", place.line.unwrap_or(0))
            }
            other => other.to_string(),
        };
        self.dropped[kind].get_or_insert(why);
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
                let name = KINDS[kind];
                let why = format!("face names {name} {index}, but there are {count} before it");
                let fault = self.fault(why, "use indices from 1, or from -1 backwards");
                self.drop_or_refuse(kind, fault)?;
            }
        }
        Ok(())
    }

    /// Returns a fault of vertices, and drops other kinds of elements because of it.
    fn drop_or_refuse(&mut self, kind: usize, fault: SceneError) -> Result<(), SceneError> {
        if kind == 0 {
            return Err(fault);
        }
        self.drop_kind(kind, &fault);
        Ok(())
    }

    fn check_greatest(&mut self) -> Result<(), SceneError> {
        for (kind, (index, line)) in self.greatest.into_iter().enumerate() {
            let (name, count) = (KINDS[kind], self.counts[kind]);
            if index > count {
                self.line = line;
                let why = format!("face names {name} {index}, but the file has {count}");
                let fault = self.fault(why, "check that the file is complete");
                self.drop_or_refuse(kind, fault)?;
            }
        }
        Ok(())
    }

    /// Returns an error if a face uses an unusable vertex.
    fn check_vertices(&mut self) -> Result<(), SceneError> {
        if self.unusable.is_empty() {
            return Ok(());
        }
        let mut used = HashSet::new();
        let mut count = 0;
        for line in self.clean.statements.split(|&byte| byte == b'\n') {
            if line.starts_with(b"v ") {
                count += 1;
            }
            let Some(corners) = line.strip_prefix(b"f ") else {
                continue;
            };
            for corner in corners.split(|&byte| byte == b' ') {
                let vertex = corner
                    .split(|&byte| byte == b'/')
                    .next()
                    .unwrap_or_default();
                let index: i64 = std::str::from_utf8(vertex)
                    .ok()
                    .and_then(|vertex| vertex.parse().ok())
                    .unwrap_or(0);
                used.insert(match index {
                    back if back < 0 => count + 1 + back,
                    index => index,
                });
            }
        }
        for (vertex, line, why) in &self.unusable {
            if used.contains(&(*vertex as i64)) {
                self.line = *line;
                return Err(self.fault(why.clone(), "use finite numbers below 3.4e38"));
            }
        }
        let (count, (_, line, why)) = (self.unusable.len(), &self.unusable[0]);
        self.clean.notices.push(format!(
            "{count} vertices that no face uses are ignored: line {line}: {why}"
        ));
        Ok(())
    }

    /// Removes attributes from all faces that are dropped.
    fn drop_attributes(&mut self) {
        if self.dropped.iter().all(Option::is_none) {
            return;
        }
        let statements = std::mem::take(&mut self.clean.statements);
        for line in statements.split_inclusive(|&byte| byte == b'\n') {
            if !line.starts_with(b"f ") {
                self.clean.statements.extend_from_slice(line);
                continue;
            }
            let line = String::from_utf8_lossy(line);
            let corners = line.split_whitespace().skip(1);
            let corners: Vec<String> = corners.map(|corner| self.kept_parts(corner)).collect();
            let corners: Vec<&str> = corners.iter().map(String::as_str).collect();
            self.keep("f", &corners);
        }
        for (kind, why) in KINDS.iter().zip(&self.dropped) {
            if let Some(why) = why {
                self.clean
                    .notices
                    .push(format!("{kind}s are ignored: {why}"));
            }
        }
    }

    /// Returns a corner without the dropped attributes.
    fn kept_parts(&self, corner: &str) -> String {
        let parts = corner.split('/').zip(&self.dropped);
        let kept = parts.map(|(part, dropped)| if dropped.is_some() { "" } else { part });
        let kept: Vec<&str> = kept.collect();
        kept.join("/").trim_end_matches('/').to_owned()
    }

    fn list_ignored(&mut self) {
        if self.ignored.is_empty() {
            return;
        }
        let mut names: Vec<String> = self
            .ignored
            .iter()
            .take(MOST_NAMES)
            .map(|(keyword, count)| format!("{} ({count})", keyword.escape_debug()))
            .collect();
        if self.ignored.len() > MOST_NAMES {
            names.push(format!("and {} others", self.ignored.len() - MOST_NAMES));
        }
        let notice = format!("statements are ignored: {}", names.join(", "));
        self.clean.notices.push(notice);
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
