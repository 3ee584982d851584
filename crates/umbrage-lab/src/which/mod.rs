//! "Which technique should I use?": a page of answers by kind of light, scene size, motion and
//! budget. It is computed only from the results of a comparison and of `stability`.
//!
//! * `groups`: scenes of one kind of light and one size, and the best setting for each motion and
//!   budget.
//! * `document`: text, tables and images, written as Markdown and as HTML.
//! * `words`: the page's text. `pictures`: small images of truth, mask and error of each answer.

mod document;
mod groups;
mod pictures;
mod words;

use crate::{
    error::LabError,
    output::folder::Folder,
    report::{MeasuredScene, StabilitySource, measured_scenes},
};
use std::path::{Path, PathBuf};
use umbrage_core::Invalid;

/// Folder of the images, next to the page.
const PICTURES: &str = "which";

/// Writes `which.md`, `which.html` and the folder `which` with their images into `out`. Returns the
/// paths of the two pages.
///
/// `compared` and `stability` are folders that `compare` and `stability` wrote. `command` is the
/// command that regenerates the page.
///
/// # Errors
/// Errors if a folder has no such results, if none of them are full-size scenes, or if a file
/// cannot be read or written.
pub fn write(
    compared: &Path,
    stability: &Path,
    out: &Path,
    command: &str,
) -> Result<[PathBuf; 2], LabError> {
    let scenes = measured_scenes(compared)?;
    let stability = StabilitySource::read(stability)?;
    let groups = groups::groups(&scenes);
    if groups.is_empty() {
        let why = "has no full-size scenes with errors";
        let help = "pass the folder of a `compare` of the built-in suite";
        let what = format!("folder `{}`", compared.display());
        return Err(Invalid::new(what, why, help).into());
    }
    let folder = Folder::create(out)?;
    let shown = pictures::write(&folder, &groups, &scenes)?;
    let page = words::AnswerWords {
        scenes: &scenes,
        groups: &groups,
        stability: &stability,
        pictures: &shown,
        command,
    };
    let document = page.document();
    folder.write("which.md", document.markdown().as_bytes())?;
    folder.write("which.html", document.html().as_bytes())?;
    Ok(["which.md", "which.html"].map(|name| out.join(name)))
}

/// Returns the environment of the first scene's results, which stands for all of them.
fn environment(scenes: &[MeasuredScene]) -> &crate::compare::Environment {
    // `write` rejects a folder without scenes.
    &scenes[0].environment
}

#[cfg(test)]
mod tests;
