//! Writes the comparison of plans with sweeps as a table.

use crate::{
    error::LabError,
    output::{csv, folder::Folder},
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use umbrage_plan::Regret;

/// A line of `regret.csv`. Errors are root mean square differences of visibility from truth. Times
/// are milliseconds by the price list. Fields are empty for missing results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegretLine {
    /// [`Regret::scene`].
    pub scene: String,
    /// [`Regret::light`].
    pub light: String,
    /// [`Regret::light_number`].
    pub light_number: usize,
    /// [`Regret::bound`].
    pub bound: f64,
    /// The planned technique. Empty if nothing was found.
    pub technique: String,
    /// Settings of the technique.
    pub settings: String,
    /// Error predicted from the sample.
    pub predicted: Option<f64>,
    /// Upper bound of the predicted error: one in twenty errors exceeds it.
    pub predicted_most: Option<f64>,
    /// Error over the whole image.
    pub error: Option<f64>,
    /// Predicted cost of the plan, milliseconds.
    pub ms: Option<f64>,
    /// The cheapest setting of the sweep. Empty if nothing was found.
    pub cheapest: String,
    /// Predicted cost of the cheapest setting, milliseconds.
    pub least_ms: Option<f64>,
    /// [`Regret::ratio`].
    pub ratio: Option<f64>,
    /// Measured time of the plan, milliseconds.
    pub clock_ms: Option<f64>,
    /// The fastest measured candidate, with its settings. Empty if nothing was timed.
    pub quickest: String,
    /// Measured time of the fastest candidate, milliseconds.
    pub least_clock_ms: Option<f64>,
    /// [`ClockRegret::ratio`](umbrage_plan::ClockRegret::ratio).
    pub clock_ratio: Option<f64>,
    /// [`Regret::seconds`].
    pub seconds: f64,
    /// [`Regret::keeps`].
    pub keeps: bool,
    /// [`Regret::misses`].
    pub misses: bool,
}

impl From<&Regret> for RegretLine {
    fn from(r: &Regret) -> Self {
        let chosen = r.chosen.as_ref();
        Self {
            scene: r.scene.clone(),
            light: r.light.clone(),
            light_number: r.light_number,
            bound: r.bound,
            technique: chosen.map_or_else(String::new, |c| c.technique.clone()),
            settings: chosen.map_or_else(String::new, |c| c.settings.clone()),
            predicted: chosen.map(|c| c.estimate.error),
            predicted_most: chosen.map(|c| c.estimate.high),
            error: chosen.map(|_| r.error),
            ms: chosen.map(|c| c.milliseconds),
            cheapest: r.cheapest.clone().unwrap_or_default(),
            least_ms: r.cheapest.as_ref().map(|_| r.min_milliseconds),
            ratio: r.ratio(),
            clock_ms: r.clock.as_ref().map(|c| c.chosen_ms),
            quickest: r
                .clock
                .as_ref()
                .map_or_else(String::new, |c| c.quickest.clone()),
            least_clock_ms: r.clock.as_ref().map(|c| c.least_ms),
            clock_ratio: r.clock.as_ref().map(umbrage_plan::ClockRegret::ratio),
            seconds: r.seconds,
            keeps: r.keeps(),
            misses: r.misses(),
        }
    }
}

/// Writes `regret.csv` into a folder, which is created if necessary: one [`RegretLine`] for each
/// scene, light and bound. Returns its path.
///
/// # Errors
/// Errors if it can't be written.
pub fn write_regret(all: &[Regret], folder: &Path) -> Result<PathBuf, LabError> {
    let table = csv::of_records(FILE, all.iter().map(RegretLine::from))?;
    Folder::create(folder)?.write(FILE, &table)?;
    Ok(folder.join(FILE))
}

const FILE: &str = "regret.csv";

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_plan::{Estimate, Setting};
    use umbrage_techniques::TechniquePreset;

    #[test]
    fn every_figure_has_a_column_of_its_own() {
        let estimate = Estimate {
            error: 0.25,
            high: 0.5,
            ..Estimate::default()
        };
        let chosen = Setting {
            preset: TechniquePreset::defaults()[0].clone(),
            technique: "pcf".to_owned(),
            settings: "3x3, 512".to_owned(),
            estimate,
            milliseconds: 1.5,
            draw_ms: 1.0,
            kept_as_camera_moves: None,
            bytes: 4,
            grain: None,
            shimmer: None,
            measured_ms: None,
            cameras: Vec::new(),
        };
        let found = Regret {
            scene: "a, b".to_owned(),
            light: "point".to_owned(),
            light_number: 2,
            bound: 0.3,
            chosen: Some(chosen),
            error: 0.26,
            cheapest: Some("hard (512)".to_owned()),
            min_milliseconds: 1.0,
            clock: Some(umbrage_plan::ClockRegret {
                chosen_ms: 3.0,
                least_ms: 2.5,
                quickest: "pcf (3x3, 512)".to_owned(),
                candidates: 7,
            }),
            seconds: 2.0,
        };
        let nothing = Regret {
            chosen: None,
            error: f64::NAN,
            cheapest: None,
            min_milliseconds: f64::NAN,
            clock: None,
            ..found.clone()
        };
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = write_regret(&[found.clone(), nothing.clone()], dir.path()).expect("writable");
        let mut reader = ::csv::Reader::from_path(path).expect("there");
        let lines: Vec<RegretLine> = reader.deserialize().map(|l| l.expect("a line")).collect();
        assert_eq!(
            lines,
            [RegretLine::from(&found), RegretLine::from(&nothing)]
        );
        let figures = [
            lines[0].predicted,
            lines[0].predicted_most,
            lines[0].error,
            lines[0].ms,
            lines[0].ratio,
        ];
        assert_eq!(figures, [0.25, 0.5, 0.26, 1.5, 1.5].map(Some));
        let by_clock = [
            lines[0].clock_ms,
            lines[0].least_clock_ms,
            lines[0].clock_ratio,
        ];
        assert_eq!(by_clock, [3.0, 2.5, 1.2].map(Some));
        assert_eq!(lines[1].clock_ratio, None);
        assert_eq!(
            [
                lines[1].predicted,
                lines[1].error,
                lines[1].least_ms,
                lines[1].ratio
            ],
            [None; 4]
        );
        assert!(
            lines[0].keeps && lines[0].misses,
            "within its bound, but expensive"
        );
    }
}
