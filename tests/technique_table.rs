//! The README's table of techniques, which is made from the registry.

use std::{fs, path::PathBuf};

/// What `cargo xtask bless` calls it.
pub const NAME: &str = "techniques";

/// The lines around the table.
const MARKS: [&str; 2] = [
    "<!-- techniques: written by `cargo xtask bless techniques` -->\n",
    "<!-- end of techniques -->\n",
];

/// Returns the file that holds the table.
pub fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../README.md")
}

/// Returns the table as it should be.
pub fn table() -> String {
    let mut out = "| name | what it does |\n|---|---|\n".to_owned();
    for entry in umbrage_techniques::all() {
        out += &format!("| `{}` | {} |\n", entry.name, entry.summary);
    }
    out
}

/// Returns `text` with the table between its marks replaced by `table`.
///
/// # Errors
/// Errors if a mark is missing.
pub fn with_table(text: &str, table: &str) -> Result<String, String> {
    let missing = |mark: &str| format!("the README has no line `{}`", mark.trim_end());
    let [begin, end] = MARKS;
    let (before, rest) = text.split_once(begin).ok_or_else(|| missing(begin))?;
    let (_, after) = rest.split_once(end).ok_or_else(|| missing(end))?;
    Ok([before, begin, table, end, after].concat())
}

/// Objects unless the README holds the table.
///
/// # Errors
/// Errors if it doesn't, or can't be read; in words.
pub fn check() -> Result<(), String> {
    let text = read()?;
    if with_table(&text, &table())? == text {
        Ok(())
    } else {
        Err("its table of techniques is not the registry's".to_owned())
    }
}

/// Writes the table into the README.
///
/// # Errors
/// Errors if it can't be read or written; in words.
pub fn bless() -> Result<(), String> {
    let text = with_table(&read()?, &table())?;
    fs::write(path(), text).map_err(|e| format!("{}: {e}", path().display()))
}

fn read() -> Result<String, String> {
    fs::read_to_string(path()).map_err(|e| format!("{}: {e}", path().display()))
}
