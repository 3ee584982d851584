//! The README's table of techniques, which is generated from the registry.

use std::{fs, path::PathBuf};

/// Name of the table for `cargo xtask bless`.
pub const NAME: &str = "techniques";

/// The lines around the table.
const MARKS: [&str; 2] = [
    "<!-- techniques: written by `cargo xtask bless techniques` -->\n",
    "<!-- end of techniques -->\n",
];

/// Returns the path of the file with the table.
pub fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../README.md")
}

macro_rules! type_names {
    ($($technique:ty,)*) => { vec![$(std::any::type_name::<$technique>(),)*] };
}

/// Returns `Pcf` of `a::MapTechnique<b::Pcf>`, and `Exact` of `c::Exact`.
fn short_name(type_name: &str) -> &str {
    let innermost = type_name.rsplit('<').next().unwrap_or(type_name);
    let path = innermost.trim_end_matches('>');
    path.rsplit("::").next().unwrap_or(path)
}

/// Returns the current table.
pub fn table() -> String {
    let types = umbrage_techniques::for_each_technique!(type_names);
    let mut out = "| name | Rust type | what it does |\n|---|---|---|\n".to_owned();
    for (entry, type_name) in umbrage_techniques::all().iter().zip(types) {
        let type_name = short_name(type_name);
        out += &format!("| `{}` | `{type_name}` | {} |\n", entry.name, entry.summary);
    }
    out
}

/// Returns `text` with the table between its marks replaced by `table`.
///
/// # Errors
/// Returns an error if a mark is missing.
pub fn with_table(text: &str, table: &str) -> Result<String, String> {
    let missing = |mark: &str| format!("the README has no line `{}`", mark.trim_end());
    let [begin, end] = MARKS;
    let (before, rest) = text.split_once(begin).ok_or_else(|| missing(begin))?;
    let (_, after) = rest.split_once(end).ok_or_else(|| missing(end))?;
    Ok([before, begin, table, end, after].concat())
}

/// Checks that the README has the table.
///
/// # Errors
/// Returns an error message if it doesn't, or can't be read.
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
/// Returns an error message if it can't be read or written.
pub fn bless() -> Result<(), String> {
    let text = with_table(&read()?, &table())?;
    fs::write(path(), text).map_err(|e| format!("{}: {e}", path().display()))
}

fn read() -> Result<String, String> {
    fs::read_to_string(path()).map_err(|e| format!("{}: {e}", path().display()))
}
