//! The WGSL of every technique as pasted into a user's shader. A checksum of each is kept in git,
//! and the last text with that checksum in `target/assembled`.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use similar::TextDiff;
use std::{fs, io::Write as _, path::PathBuf};
use umbrage_core::ShadowTechnique;
use umbrage_lab::assembled_wgsl;
use umbrage_techniques::TechniquePreset;

/// Prefix of every name in the kept texts.
pub const PREFIX: &str = "shadow_";

/// The text of a technique.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// The technique's name.
    pub name: String,
    /// The text as currently assembled.
    pub text: String,
}

/// Returns the texts of all built-in techniques with their default settings.
///
/// # Panics
/// Panics if a technique supports neither the sun nor a point light.
pub fn all() -> Vec<Assembled> {
    TechniquePreset::defaults()
        .into_iter()
        .map(|preset| {
            let technique = preset.technique();
            Assembled {
                name: technique.name().to_owned(),
                text: assemble(&*technique, PREFIX),
            }
        })
        .collect()
}

/// Returns the text of a technique, whose names start with `prefix`.
///
/// # Panics
/// Panics if the technique supports neither the sun nor a point light, or if the prefix is not the
/// start of a name.
pub fn assemble(technique: &dyn ShadowTechnique, prefix: &str) -> String {
    let text = assembled_wgsl(technique, prefix);
    text.unwrap_or_else(|why| panic!("{}: {why}", technique.name()))
}

/// Checks that a text is a valid WGSL module.
///
/// # Errors
/// Returns naga's error.
pub fn validate(text: &str) -> Result<(), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| e.emit_to_string(text))?;
    Ok(())
}

/// Returns the path of the file of checksums, with a line `NAME CHECKSUM` for each technique.
pub fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assembled.txt")
}

/// Returns the kept names and checksums.
///
/// # Errors
/// Returns an error if the file can't be read.
pub fn kept_checksums() -> Result<Vec<(String, String)>, String> {
    let path = path();
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let lines = text.lines().filter_map(|line| line.split_once(' '));
    Ok(lines
        .map(|(name, sum)| (name.to_owned(), sum.to_owned()))
        .collect())
}

fn checksum(text: &str) -> String {
    format!("{:08x}", crc32fast::hash(text.as_bytes()))
}

impl Assembled {
    /// Returns the path of the last text with the kept checksum.
    fn kept_text(&self) -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("../target/assembled")
            .join(format!("{}.wgsl", self.name))
    }

    /// Checks that the kept checksum is that of the current text, and keeps the text.
    ///
    /// # Errors
    /// Returns an error with the difference to the kept text.
    pub fn check(&self) -> Result<(), String> {
        let kept = kept_checksums()?;
        let sum = kept.iter().find(|(name, _)| *name == self.name);
        let name = &self.name;
        let Some((_, sum)) = sum else {
            return Err(format!("{name}: no checksum is kept"));
        };
        if *sum == checksum(&self.text) {
            return self.keep_text();
        }
        let earlier = fs::read_to_string(self.kept_text()).unwrap_or_default();
        if *sum == checksum(&earlier) {
            return Err(format!("{name}:\n{}", difference(&earlier, &self.text)));
        }
        Err(format!(
            "{name}: the text of this checksum is not in {}; tests of an earlier commit put it there",
            self.kept_text().display()
        ))
    }

    fn keep_text(&self) -> Result<(), String> {
        let path = self.kept_text();
        let reported = |e: std::io::Error| format!("{}: {e}", path.display());
        if fs::read_to_string(&path).is_ok_and(|text| text == self.text) {
            return Ok(());
        }
        let folder = path.parent().expect("a folder");
        fs::create_dir_all(folder).map_err(reported)?;
        // Write and rename, so that a test on another thread never reads a partial file.
        let mut whole = tempfile::NamedTempFile::new_in(folder).map_err(reported)?;
        whole.write_all(self.text.as_bytes()).map_err(reported)?;
        whole.persist(&path).map_err(|e| reported(e.error))?;
        Ok(())
    }

    /// Keeps the current text and its checksum.
    ///
    /// # Errors
    /// Returns an error if a file can't be written.
    pub fn bless(&self) -> Result<(), String> {
        let mut kept = kept_checksums().unwrap_or_default();
        kept.retain(|(name, _)| *name != self.name);
        kept.push((self.name.clone(), checksum(&self.text)));
        kept.sort();
        let lines: String = kept.iter().map(|(n, sum)| format!("{n} {sum}\n")).collect();
        fs::write(path(), lines).map_err(|e| format!("{}: {e}", path().display()))?;
        self.keep_text()
    }
}

/// Returns the different lines, with three lines around each change.
pub fn difference(kept: &str, now: &str) -> String {
    let difference = TextDiff::from_lines(kept, now);
    difference.unified_diff().header("kept", "now").to_string()
}
