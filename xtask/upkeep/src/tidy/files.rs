//! Files that `tidy` checks.

use anyhow::{Context as _, Result};
use std::{fs, path::Path};

/// A text file.
#[derive(Debug)]
pub(crate) struct SourceFile {
    /// Path relative to the top folder.
    pub(crate) path: String,
    pub(crate) text: String,
}

impl SourceFile {
    pub(crate) fn extension(&self) -> &str {
        self.path.rsplit_once('.').map_or("", |(_, e)| e)
    }
}

/// Returns every Rust, WGSL, TOML and Markdown file below `root`, sorted by path.
pub(crate) fn read_all(root: &Path) -> Result<Vec<SourceFile>> {
    let mut out = Vec::new();
    read_folder(root, "", &mut out)?;
    out.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(out)
}

fn read_folder(folder: &Path, prefix: &str, out: &mut Vec<SourceFile>) -> Result<()> {
    for entry in
        fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?
    {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = format!("{prefix}{name}");
        if entry.file_type()?.is_dir() {
            // Skip cargo's output and hidden folders.
            if name != "target" && !name.starts_with('.') {
                read_folder(&entry.path(), &format!("{path}/"), out)?;
            }
        } else if matches!(
            name.rsplit_once('.'),
            Some((_, "rs" | "wgsl" | "toml" | "md"))
        ) {
            let text =
                fs::read_to_string(entry.path()).with_context(|| format!("cannot read {path}"))?;
            out.push(SourceFile { path, text });
        }
    }
    Ok(())
}
