//! "Which technique should I use?": a page of answers by kind of light, size of scene, motion and
//! budget, made from the results of a comparison and of `stability` alone.
//!
//! * `groups`: the scenes of one kind of light and one size, and for each motion and budget the
//!   setting that does best.
//! * `document`: text, tables and pictures, written as Markdown and as HTML.
//! * `words`: what the page says. `pictures`: truth, mask and error of each answer, small.

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

/// Where the pictures lie, beside the page.
const PICTURES: &str = "which";

/// Writes `which.md`, `which.html` and the folder `which` with their pictures into `out`.
/// `compared` and `stability` are folders that `compare` and `stability` wrote; `command`: how the
/// page is made again. Returns the paths of the two pages.
///
/// # Errors
/// Errors if a folder holds no such results, if there are no frames of real size among them, or if
/// a file cannot be read or written.
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
        let why = "has no frames of real size with errors";
        let help = "give the folder of a `compare` of the built-in suite";
        let what = format!("folder `{}`", compared.display());
        return Err(Invalid::new(what, why, help).into());
    }
    let folder = Folder::create(out)?;
    let shown = pictures::write(&folder, &groups, &scenes)?;
    let page = words::Words {
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

/// Returns the first scene's results, which say where all were measured.
fn environment(scenes: &[MeasuredScene]) -> &crate::compare::Environment {
    // `write` refuses a folder without scenes.
    &scenes[0].environment
}

#[cfg(test)]
mod tests;
