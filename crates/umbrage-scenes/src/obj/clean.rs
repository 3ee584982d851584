//! Reads OBJ text and hands on only what makes a mesh, checked, in the form that `tobj` reads rightly.
//!
//! Left to itself `tobj` 4.0 takes lines for faces, loses the first vertex after a byte order mark, fails on comments
//! behind faces, on continued lines, on a lone carriage return, on vertices of which only some are coloured and on
//! names that aren't UTF-8, overflows on indices far out of range, and can't say in which line a fault is.

use super::parts::Looks;
use std::io::{self, BufRead, Read};

/// Longest line that is read: a face with a million corners fits, and a file without line ends can't fill the memory.
const LONGEST_LINE: u64 = 16 << 20;
/// Most corners of one face: cutting concave polygons takes time that grows with their square.
const MOST_CORNERS: usize = 4096;

/// What is wrong in which line, counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    pub(super) line: usize,
    pub(super) why: String,
    pub(super) help: &'static str,
}

/// The clean text, one statement at a time.
#[derive(Debug)]
pub(super) struct Cleaner<R> {
    source: R,
    line: usize,
    /// A statement that goes on in the next line.
    continued: String,
    clean: io::Cursor<Vec<u8>>,
    /// Vertices, texture coordinates and normals so far.
    counts: [usize; 3],
    /// The greatest index of each so far, and its line.
    greatest: [(usize, usize); 3],
    pub(super) faces: usize,
    pub(super) looks: Looks,
    /// Why reading stopped, if the text is at fault.
    pub(super) fault: Option<Fault>,
    /// Why reading stopped, if the source failed.
    pub(super) failure: Option<io::Error>,
}

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl<R: BufRead> Cleaner<R> {
    pub(super) fn new(source: R) -> Self {
        Self {
            source,
            line: 0,
            continued: String::new(),
            clean: io::Cursor::default(),
            counts: [0; 3],
            greatest: [(0, 0); 3],
            faces: 0,
            looks: Looks::default(),
            fault: None,
            failure: None,
        }
    }

    /// Cleans up to the next line feed. False at the end.
    fn advance(&mut self) -> io::Result<bool> {
        let mut bytes = Vec::new();
        let read = (&mut self.source)
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut bytes);
        if read.or_else(|error| self.fail(error))? == 0 {
            let rest = std::mem::take(&mut self.continued);
            let end = self.statement(&rest).and_then(|()| self.check_greatest());
            return self.stop_at(end).map(|()| false);
        }
        self.clean.get_mut().clear();
        self.clean.set_position(0);
        let cleaned = self.clean_line(&bytes);
        self.stop_at(cleaned).map(|()| true)
    }

    fn fail(&mut self, error: io::Error) -> io::Result<usize> {
        let kind = error.kind();
        self.failure = Some(error);
        Err(kind.into())
    }

    fn stop_at(&mut self, result: Result<(), Fault>) -> io::Result<()> {
        result.map_err(|fault| {
            self.fault = Some(fault);
            io::Error::from(io::ErrorKind::InvalidData)
        })
    }

    fn clean_line(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let bytes = if self.line == 0 {
            bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
        } else {
            bytes
        };
        let fault = if bytes.contains(&0) {
            Some("is not text")
        } else if bytes.len() as u64 == LONGEST_LINE {
            Some("is over 16 MiB long")
        } else {
            None
        };
        if let Some(why) = fault {
            self.line += 1;
            let help = "save the model as a Wavefront OBJ in ASCII or UTF-8";
            return self.fault(why.to_owned(), help);
        }
        let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        let bytes = bytes.strip_suffix(b"\r").unwrap_or(bytes);
        // A lone carriage return ends a line, too.
        for line in bytes.split(|&b| b == b'\r') {
            self.line += 1;
            let text = String::from_utf8_lossy(line);
            let without_comment = text.split('#').next().unwrap_or_default();
            match without_comment.trim_end().strip_suffix('\\') {
                Some(part) => {
                    self.continued.push_str(part);
                    self.continued.push(' ');
                }
                None if self.continued.is_empty() => self.statement(without_comment)?,
                None => {
                    let whole = std::mem::take(&mut self.continued) + without_comment;
                    self.statement(&whole)?;
                }
            }
        }
        Ok(())
    }

    fn statement(&mut self, text: &str) -> Result<(), Fault> {
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => self.vertex(&words.collect::<Vec<_>>()),
            Some("vt") => self.texture_coordinate(&words.collect::<Vec<_>>()),
            Some("vn") => self.normal(&words.collect::<Vec<_>>()),
            Some("f") => self.face(&words.collect::<Vec<_>>()),
            Some("usemtl") => self.look(|looks, faces, name| looks.runs.push((faces, name)), text),
            Some("mtllib") => self.look(|looks, _, name| looks.libraries.push(name), text),
            // Names, lines, points and curves make no triangles.
            _ => Ok(()),
        }
    }

    /// Looks are kept aside: `tobj` would split the mesh at each, and doesn't say which file a name is from.
    fn look(
        &mut self,
        keep: impl FnOnce(&mut Looks, usize, String),
        text: &str,
    ) -> Result<(), Fault> {
        let name = text
            .trim()
            .split_once(char::is_whitespace)
            .map_or("", |(_, name)| name.trim());
        keep(&mut self.looks, self.faces, name.to_owned());
        Ok(())
    }

    fn vertex(&mut self, words: &[&str]) -> Result<(), Fault> {
        let xyz = self.numbers::<3>("vertex", words)?;
        // Exactly four numbers: the last is a weight. Beyond that they are a colour.
        let w = if words.len() == 4 {
            self.numbers::<1>("weight", &words[3..])?[0]
        } else {
            1.0
        };
        if let Some(bad) = xyz.iter().find(|x| !(*x / w).is_finite()) {
            let why = if w == 1.0 {
                format!("vertex holds {bad}")
            } else {
                format!("vertex holds {bad} over {w}")
            };
            return self.fault(why, "use finite numbers below 3.4e38");
        }
        self.counts[0] += 1;
        let used = if words.len() == 4 { 4 } else { 3 };
        self.emit("v", &words[..used]);
        Ok(())
    }

    fn texture_coordinate(&mut self, words: &[&str]) -> Result<(), Fault> {
        let u = self.numbers::<1>("texture coordinate", words)?[0];
        let v = if words.len() > 1 {
            self.numbers::<1>("texture coordinate", &words[1..])?[0]
        } else {
            0.0
        };
        self.counts[1] += 1;
        self.emit("vt", &[&u.to_string(), &v.to_string()]);
        Ok(())
    }

    fn normal(&mut self, words: &[&str]) -> Result<(), Fault> {
        self.numbers::<3>("normal", words)?;
        self.counts[2] += 1;
        self.emit("vn", &words[..3]);
        Ok(())
    }

    fn face(&mut self, words: &[&str]) -> Result<(), Fault> {
        words.iter().try_for_each(|word| self.corner(word))?;
        if words.len() > MOST_CORNERS {
            let why = format!("face has {} corners", words.len());
            return self.fault(
                why,
                "export the model as triangles: a face may have at most 4,096 corners",
            );
        }
        // With fewer corners it has no area, and casts no shadow.
        if words.len() >= 3 {
            self.faces += 1;
            self.emit("f", words);
        }
        Ok(())
    }

    fn corner(&mut self, word: &str) -> Result<(), Fault> {
        const HELP: &str = "write corners as `v`, `v/vt`, `v//vn` or `v/vt/vn` with whole numbers";
        for (kind, part) in word.split('/').enumerate() {
            match part.parse::<i64>() {
                _ if kind > 2 => {
                    return self.fault(format!("face corner `{word}` has too many parts"), HELP);
                }
                Ok(index) => self.index(kind, index)?,
                Err(_) if part.is_empty() && kind > 0 => {}
                Err(_) => return self.fault(format!("face corner `{word}` is not an index"), HELP),
            }
        }
        Ok(())
    }

    /// Negative indices count back from the latest; positive ones may run ahead, and are checked at the end.
    fn index(&mut self, kind: usize, index: i64) -> Result<(), Fault> {
        let size = index.unsigned_abs() as usize;
        let count = self.counts[kind];
        if index > 0 {
            if size > self.greatest[kind].0 {
                self.greatest[kind] = (size, self.line);
            }
            return Ok(());
        }
        if index == 0 || size > count {
            let why = format!(
                "face names {} {index}, but there are {count} before it",
                KINDS[kind]
            );
            return self.fault(why, "use indices from 1, or from -1 backwards");
        }
        Ok(())
    }

    fn check_greatest(&mut self) -> Result<(), Fault> {
        for ((kind, (index, line)), count) in KINDS.iter().zip(self.greatest).zip(self.counts) {
            if index > count {
                let why = format!("face names {kind} {index}, but the file has {count}");
                return Err(Fault {
                    line,
                    why,
                    help: "check that the file is complete",
                });
            }
        }
        Ok(())
    }

    fn numbers<const N: usize>(&self, what: &str, words: &[&str]) -> Result<[f32; N], Fault> {
        let mut out = [0.0; N];
        for (i, number) in out.iter_mut().enumerate() {
            match words.get(i).map(|word| (word, word.parse())) {
                Some((_, Ok(parsed))) => *number = parsed,
                Some((word, Err(_))) => {
                    self.fault(
                        format!("{what} holds `{word}`, which is not a number"),
                        "write numbers as 1.5 or 2e-3",
                    )?;
                }
                None => self.fault(
                    format!("{what} has {i} numbers of {N}"),
                    "check that the file is complete",
                )?,
            }
        }
        Ok(out)
    }

    fn fault(&self, why: String, help: &'static str) -> Result<(), Fault> {
        Err(Fault {
            line: self.line,
            why,
            help,
        })
    }

    fn emit(&mut self, keyword: &str, words: &[&str]) {
        let out = self.clean.get_mut();
        out.extend_from_slice(keyword.as_bytes());
        for word in words {
            out.push(b' ');
            out.extend_from_slice(word.as_bytes());
        }
        out.push(b'\n');
    }
}

impl<R: BufRead> Read for Cleaner<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            let n = self.clean.read(out)?;
            if n > 0 || out.is_empty() {
                return Ok(n);
            }
            if !self.advance()? && self.clean.position() == self.clean.get_ref().len() as u64 {
                return Ok(0);
            }
        }
    }
}
