//! Reads a repository's commit. `xtask-upkeep` compiles this file, too.

use std::{path::Path, process::Command};

/// Returns the commit of a folder's repository, with `+` if files were changed. `None` outside a
/// repository.
pub(crate) fn commit(folder: &Path) -> Option<String> {
    let git = |arguments: &[&str]| {
        let mut command = Command::new("git");
        let output = command.current_dir(folder).args(arguments).output().ok()?;
        let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        (output.status.success() && !text.is_empty()).then_some(text)
    };
    let hash = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changes = git(&["status", "--porcelain", "--untracked-files=no"]);
    Some(if changes.is_some() { hash + "+" } else { hash })
}
