//! `work.csv`: the counted work of each row and its time, for fitting other prices.

use crate::compare::{CompareRow, Comparison, SceneResult, TimingStats};
use crate::{error::LabError, output::csv};
use serde::{Deserialize, Serialize};
use umbrage_plan::cost::Work;

/// A line of `work.csv`: a row that was timed and doesn't repeat another.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct WorkLine {
    scene: String,
    backend: String,
    /// Technique and settings of the row, as in the names of its images.
    slug: String,
    passes: u64,
    triangles: u64,
    covered: u64,
    cut_out: u64,
    cleared: u64,
    filtered: u64,
    filter_taps: u64,
    receivers: u64,
    taps: u64,
    samples: u64,
    rays: u64,
    casters: u64,
    placed: u64,
    walks: u64,
    faces: u64,
    counted: u64,
    /// Time of casts and filters: the least of the runs, milliseconds.
    draw_ms: f64,
    /// Time of the lookup: the least of the runs, milliseconds.
    lookup_ms: f64,
}

/// Returns the text of the file.
///
/// # Errors
/// Errors if it can't be written to memory.
pub(super) fn to_csv(comparison: &Comparison) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for scene in &comparison.scenes {
        for row in scene.rows.iter().filter(|row| row.same_as.is_none()) {
            lines.extend(line(scene, row));
        }
    }
    csv::of_records("work.csv", lines)
}

/// Returns the least time of a stage; 0 if it was not timed.
fn least(stage: Option<TimingStats>) -> f64 {
    stage.map_or(0.0, |stats| stats.min)
}

/// Returns a row's line; `None` if it was not timed.
fn line(scene: &SceneResult, row: &CompareRow) -> Option<WorkLine> {
    let measured = row.measured_figures()?;
    let times = measured.times?;
    let Work {
        passes,
        triangles,
        covered,
        cut_out,
        // Not part of the timed work.
        listed: _,
        cleared,
        filtered,
        filter_taps,
        receivers,
        taps,
        samples,
        rays,
        casters,
        placed,
        walks,
        faces,
        counted,
        bytes: _,
    } = measured.work;
    Some(WorkLine {
        scene: scene.name.clone(),
        backend: row.backend.clone(),
        slug: row.slug.clone(),
        passes,
        triangles,
        covered,
        cut_out,
        cleared,
        filtered,
        filter_taps,
        receivers,
        taps,
        samples,
        rays,
        casters,
        placed,
        walks,
        faces,
        counted,
        draw_ms: least(times.cast) + least(times.filter),
        lookup_ms: least(times.receive),
    })
}
