//! `rows.csv`: a line per row, with all figures.

use crate::compare::{CompareRow, Comparison, RowOutcome, SceneResult, TimingStats};
use crate::{error::LabError, output::csv};
use serde::{Deserialize, Serialize};

/// A line of `rows.csv`. Times are medians in milliseconds; shares are percent. Empty fields were
/// not measured; errors are empty if no pixel counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Name of the scene.
    pub scene: String,
    /// Kind of light.
    pub light: String,
    /// Name of the technique.
    pub technique: String,
    /// Settings of the technique.
    pub settings: String,
    /// Kind of backend.
    pub backend: String,
    /// Reason why it was not measured; empty if it was.
    pub unsupported: String,
    /// [`Errors::rmse`](umbrage_core::metrics::Errors::rmse).
    pub rmse: Option<f64>,
    /// Mean of |mask - truth|.
    pub mean: Option<f64>,
    /// Mean of mask - truth.
    pub bias: Option<f64>,
    /// Greatest |mask - truth|.
    pub largest: Option<f64>,
    /// Percentage of false shadow.
    pub false_shadow: Option<f64>,
    /// Percentage of false light.
    pub false_light: Option<f64>,
    /// Percentage of false shadow away from edges.
    pub acne: Option<f64>,
    /// [`Causes::acne`](umbrage_core::metrics::Causes::acne); the five causes add up to `mean`.
    pub cause_acne: Option<f64>,
    /// [`Causes::gap`](umbrage_core::metrics::Causes::gap).
    pub cause_gap: Option<f64>,
    /// [`Causes::leak`](umbrage_core::metrics::Causes::leak).
    pub cause_leak: Option<f64>,
    /// [`Causes::edge`](umbrage_core::metrics::Causes::edge).
    pub cause_edge: Option<f64>,
    /// [`Causes::penumbra`](umbrage_core::metrics::Causes::penumbra).
    pub cause_penumbra: Option<f64>,
    /// [`Causes::gap_metres`](umbrage_core::metrics::Causes::gap_metres).
    pub gap_metres: Option<f64>,
    /// [`Causes::penumbra_width`](umbrage_core::metrics::Causes::penumbra_width).
    pub penumbra_width: Option<f64>,
    /// Number of counted pixels.
    pub counted: Option<u64>,
    /// Number of pixels excluded as ambiguous.
    pub ambiguous: Option<u64>,
    /// Number of pixels excluded as unlit.
    pub unlit: Option<u64>,
    /// Number of pixels excluded because the backend sees other triangles there than truth.
    pub other_triangles: Option<u64>,
    /// Counted cost of the work, equal on every run.
    pub cost_ms: Option<f64>,
    /// Time of the casts.
    pub cast_ms: Option<f64>,
    /// Time of the filters.
    pub filter_ms: Option<f64>,
    /// Time of the lookup.
    pub receive_ms: Option<f64>,
    /// Total time of the three stages, run by run.
    pub total_ms: Option<f64>,
    /// Total time of the fastest run.
    pub total_least_ms: Option<f64>,
    /// Total time of the slowest run.
    pub total_greatest_ms: Option<f64>,
    /// Median ratio of the runs to the yardsticks before and after them.
    pub yardsticks: Option<f64>,
    /// Median time of the yardstick, milliseconds per unit.
    pub yardstick_ms: Option<f64>,
    /// Total time at a device's full clock, milliseconds, as shown in charts. Empty on the CPU, and
    /// if no yardstick was steady.
    pub full_clock_ms: Option<f64>,
    /// Number of bytes used.
    pub bytes: Option<u64>,
    /// Percentage of the maps' texels that no lookup touches:
    /// [`MapUse::unused`](umbrage_plan::footprint::MapUse::unused).
    pub map_unused: Option<f64>,
    /// Fewest texels per pixel:
    /// [`MapUse::texels_per_pixel`](umbrage_plan::footprint::MapUse::texels_per_pixel).
    pub texels_least: Option<f32>,
    /// Median of the texels per pixel.
    pub texels_median: Option<f32>,
    /// Most texels per pixel.
    pub texels_greatest: Option<f32>,
    /// Least number of texels that nine in ten pixels facing the light span:
    /// [`MapUse::texels`](umbrage_plan::footprint::MapUse::texels).
    pub texels_of_nine_in_ten: Option<f32>,
    /// Side of the map at which that number is one texel:
    /// [`MapUse::side`](umbrage_plan::footprint::MapUse::side).
    pub map_side_needed: Option<u32>,
    /// Number of pixels that differ from the CPU's.
    pub differing: Option<u64>,
    /// Number of pixels on which the CPU's mask changes if it rounds vertices as the device does.
    pub by_grid: Option<u64>,
    /// Number of differing pixels that rounding explains.
    pub undecided: Option<u64>,
    /// Number of differing pixels where the backends see different triangles.
    pub elsewhere: Option<u64>,
    /// Greatest difference from the CPU's mask.
    pub largest_difference: Option<f64>,
    /// Number of decided pixels that differ; must be 0.
    pub violations: Option<u64>,
}

/// Returns all rows as lines.
pub fn lines(comparison: &Comparison) -> Vec<Line> {
    comparison
        .scenes
        .iter()
        .flat_map(|s| s.rows.iter().map(move |r| line(s, r)))
        .collect()
}

fn line(scene: &SceneResult, row: &CompareRow) -> Line {
    let named = Line {
        scene: scene.name.clone(),
        light: scene.light.clone(),
        technique: row.technique.clone(),
        settings: row.settings.clone(),
        backend: row.backend.clone(),
        ..Line::default()
    };
    let m = match &row.outcome {
        RowOutcome::Unsupported { reason } => {
            return Line {
                unsupported: reason.clone(),
                ..named
            };
        }
        RowOutcome::Measured(m) => m,
    };
    // The fewest, the median and the most texels per pixel.
    let texels = m.maps.and_then(|u| u.texels_per_pixel);
    Line {
        rmse: m.errors.map(|e| e.rmse),
        mean: m.errors.map(|e| e.mean),
        bias: m.errors.map(|e| e.bias),
        largest: m.errors.map(|e| e.largest),
        false_shadow: m.errors.map(|e| e.false_shadow),
        false_light: m.errors.map(|e| e.false_light),
        acne: m.errors.map(|e| e.acne),
        cause_acne: m.causes.map(|c| c.acne),
        cause_gap: m.causes.map(|c| c.gap),
        cause_leak: m.causes.map(|c| c.leak),
        cause_edge: m.causes.map(|c| c.edge),
        cause_penumbra: m.causes.map(|c| c.penumbra),
        gap_metres: m.causes.and_then(|c| c.gap_metres),
        penumbra_width: m.causes.and_then(|c| c.penumbra_width),
        counted: m.errors.map(|e| e.counted),
        ambiguous: m.errors.map(|e| e.ambiguous),
        unlit: m.errors.map(|e| e.unlit),
        other_triangles: m.errors.map(|e| e.elsewhere),
        cost_ms: Some(m.cost_ms),
        cast_ms: m.times.and_then(|t| median(t.cast)),
        filter_ms: m.times.and_then(|t| median(t.filter)),
        receive_ms: m.times.and_then(|t| median(t.receive)),
        total_ms: m.times.map(|t| t.total.median),
        total_least_ms: m.times.map(|t| t.total.min),
        total_greatest_ms: m.times.map(|t| t.total.max),
        yardsticks: m.times.and_then(|t| t.ratio).map(|r| r.median),
        yardstick_ms: m.times.and_then(|t| median(t.yardstick)),
        full_clock_ms: m
            .times
            .and_then(|t| Some(t.full_clock_factor? * t.total.median)),
        bytes: Some(m.bytes),
        map_unused: m.maps.map(|u| 100.0 * u.unused),
        texels_least: texels.map(|all| all[0]),
        texels_median: texels.map(|all| all[1]),
        texels_greatest: texels.map(|all| all[2]),
        texels_of_nine_in_ten: m.maps.and_then(|u| u.texels),
        map_side_needed: m.maps.and_then(|u| u.side),
        differing: m.agreement.map(|a| a.differing),
        by_grid: m.agreement.map(|a| a.by_grid),
        undecided: m.agreement.map(|a| a.undecided),
        elsewhere: m.agreement.map(|a| a.elsewhere),
        largest_difference: m.agreement.map(|a| a.largest),
        violations: m.agreement.map(|a| a.violations),
        ..named
    }
}

fn median(times: Option<TimingStats>) -> Option<f64> {
    times.map(|times| times.median)
}

/// Returns the lines as comma-separated values with a header.
///
/// # Errors
/// Errors if the text can't be written; writing to memory does not fail.
pub fn to_csv(lines: &[Line]) -> Result<Vec<u8>, LabError> {
    csv::of_records("rows.csv", lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back_whatever_they_hold() {
        let awkward = Line {
            scene: "a \"quoted\", name\nin two lines".into(),
            rmse: Some(0.1 + 0.2),
            counted: Some(7),
            unsupported: "<b>".into(),
            ..Line::default()
        };
        let lines = vec![
            awkward,
            Line {
                technique: "pcf".into(),
                ..Line::default()
            },
        ];
        let bytes = to_csv(&lines).expect("memory");
        let read: Vec<Line> = ::csv::Reader::from_reader(&bytes[..])
            .deserialize()
            .map(|l| l.expect("a line"))
            .collect();
        assert_eq!(read, lines);
    }
}
