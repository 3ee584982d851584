//! Rules for the text of files. Clippy already rejects `todo!`, `unimplemented!` and attributes
//! without a reason.

use super::files::SourceFile;

/// Marks of postponed work, split so that this file passes, too.
const LATER: [&str; 4] = [
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("#[ig", "nore"),
];

/// Returns the faults of a file, each as `path:line: fault, and remedy`.
pub(super) fn faults(source: &SourceFile) -> Vec<String> {
    let is_code = matches!(source.extension(), "rs" | "wgsl");
    let mut out = Vec::new();
    for (i, line) in source.text.lines().enumerate() {
        let mut add = |fault: &str| out.push(format!("{}:{}: {fault}", source.path, i + 1));
        if line.contains('\t') {
            add("a tab; indent with blanks");
        }
        if line.ends_with(' ') {
            add("a blank at the end of the line; remove it");
        }
        for word in LATER.iter().filter(|w| is_code && line.contains(**w)) {
            add(&format!("`{word}`; do it, or remove it"));
        }
    }
    if !source.text.ends_with('\n') || source.text.ends_with("\n\n") {
        out.push(format!("{}: end the file with one line break", source.path));
    }
    out
}
