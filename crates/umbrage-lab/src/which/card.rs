//! A graphics card's times in place of those of a comparison.

use super::groups::LabelledMotion;
use crate::{
    card::{Card, CardTime},
    compare::{CompareRow, FrameMotion, RowOutcome, RowTimes, SceneResult, TimingStats},
};

/// The motion of a card's times: they contain casts, filters and lookup, but no work of the
/// processor, such as lists of triangles.
pub(super) const CARD_MOTIONS: [LabelledMotion; 1] =
    [(FrameMotion::CameraMoves, "maps and lookup of a frame")];

/// Returns the scenes that a card has timed, with its name as their backend. Errors are those of the
/// comparison's first backend; settings without a time on the card are omitted.
pub(super) fn time_by_card(scenes: &[SceneResult], card: &Card) -> Vec<SceneResult> {
    let times = card.times.as_deref().unwrap_or_default();
    let mut out = Vec::new();
    for scene in scenes {
        let [width, height] = scene.size;
        let frame = format!("{} {width}x{height}", scene.name);
        let Some(first) = scene.rows.first() else {
            continue;
        };
        let rows = scene.rows.iter().filter(|row| row.backend == first.backend);
        let timed = rows.filter_map(|row| {
            let is_row = |time: &&CardTime| {
                time.frame == frame
                    && time.technique == row.technique
                    && time.settings == row.settings
            };
            let milliseconds = times.iter().find(is_row)?.milliseconds?;
            time_row(row, &card.adapter, milliseconds)
        });
        let rows: Vec<CompareRow> = timed.collect();
        if !rows.is_empty() {
            let scene = scene.clone();
            out.push(SceneResult { rows, ..scene });
        }
    }
    out
}

/// Returns a row with a time of another adapter. `None` if the row has no measurement.
fn time_row(row: &CompareRow, adapter: &str, milliseconds: f64) -> Option<CompareRow> {
    let time = TimingStats {
        median: milliseconds,
        min: milliseconds,
        max: milliseconds,
        runs: 1,
    };
    let mut measured = row.measured_figures()?.clone();
    // The card draws all maps in each frame, and its times have no preparation.
    measured.kept_as_camera_moves = false;
    measured.preparation = None;
    measured.times = Some(RowTimes {
        total: time,
        ..RowTimes::default()
    });
    Some(CompareRow {
        backend: adapter.to_owned(),
        outcome: RowOutcome::Measured(Box::new(measured)),
        ..row.clone()
    })
}
