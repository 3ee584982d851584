//! "Which technique should I use?": a page of answers by kind of light, scene size, motion and
//! budget. It is computed only from the results of a comparison and of `stability`.
//!
//! * `groups`: scenes of one kind of light and one size, and the best setting for each motion and
//!   budget.
//! * `card`: times of a graphics card in place of those of the comparison.
//! * `document`: text, tables and images, written as Markdown and as HTML.
//! * `words` and `cells`: the page's text. `pictures`: small images of truth, mask and error of each
//!   answer. `headline`: a chart of ten settings.

mod card;
mod cells;
mod document;
mod groups;
mod headline;
mod pictures;
mod words;

use crate::{
    card::Card,
    error::LabError,
    output::folder::Folder,
    report::{MeasuredScene, StabilitySource, measured_scenes},
};
use std::path::{Path, PathBuf};
use umbrage_core::Invalid;

/// Folder of the images, next to the page.
const PICTURES: &str = "which";

/// The chart, next to the page.
const HEADLINE: &str = "which.svg";

/// Parts of the names of adapters that run on the CPU.
const SOFTWARE: [&str; 2] = ["llvmpipe", "SwiftShader"];

/// Writes `which.md`, `which.html`, the chart `which.svg` and the folder `which` with images into
/// `out`. Returns the paths of the two pages.
///
/// `compared` and `stability` are folders that `compare` and `stability` wrote. `card` is a graphics
/// card whose times the page shows. `command` is the command that regenerates the page.
///
/// # Errors
/// Errors if a folder has no such results, if none of them are full-size scenes, or if a file
/// cannot be read or written.
pub fn write(
    compared: &Path,
    stability: &Path,
    card: Option<&Card>,
    out: &Path,
    command: &str,
) -> Result<[PathBuf; 2], LabError> {
    let scenes = measured_scenes(compared)?;
    let stability = StabilitySource::read(stability)?;
    let adapter = scenes
        .first()
        .and_then(|s| s.environment.adapter.as_deref());
    let omits_wgpu = adapter.is_some_and(is_software);
    let groups = groups::groups(&scenes, omits_wgpu, card);
    if groups.is_empty() {
        let why = "has no full-size scenes with errors";
        let help = "pass the folder of a `compare` of the built-in suite";
        let what = format!("folder `{}`", compared.display());
        return Err(Invalid::new(what, why, help).into());
    }
    let folder = Folder::create(out)?;
    let shown = pictures::write(&folder, &groups, &scenes)?;
    let chart = headline::chart(&groups);
    if let Some(chart) = &chart {
        folder.write(HEADLINE, chart.svg().as_bytes())?;
    }
    let page = words::AnswerWords {
        scenes: &scenes,
        groups: &groups,
        stability: &stability,
        pictures: &shown,
        card,
        has_chart: chart.is_some(),
        command,
    };
    let document = page.document();
    folder.write("which.md", document.markdown().as_bytes())?;
    folder.write("which.html", document.html().as_bytes())?;
    Ok(["which.md", "which.html"].map(|name| out.join(name)))
}

/// Reports whether an adapter runs on the CPU, by its name.
fn is_software(adapter: &str) -> bool {
    SOFTWARE.iter().any(|name| adapter.contains(name))
}

/// Returns the environment of the first scene's results, which stands for all of them.
fn environment(scenes: &[MeasuredScene]) -> &crate::compare::Environment {
    // `write` rejects a folder without scenes.
    &scenes[0].environment
}

#[cfg(test)]
mod tests;
