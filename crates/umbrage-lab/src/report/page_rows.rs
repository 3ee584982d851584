//! Rows of all scenes for the page, kept short, as there may be many thousands.

use crate::compare::{
    CompareRow, CostBasis, FrameMotion, Measured, RowOutcome, RowTimes, TimingStats,
};
use serde::Serialize;
use serde_json::Value;
use std::collections::HashMap;

/// Number of digits after the first.
const DIGITS: usize = 3;

/// Available images of a row.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct RowPictures {
    /// Names of the files without the last extensions. They are another row's if its images are the
    /// same.
    pub(super) stem: String,
    pub(super) color: bool,
    pub(super) lookups: bool,
}

/// A row for the page. Times are medians, milliseconds; shares are percent; `None` means not
/// measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct PageRow {
    pub(super) technique: String,
    pub(super) settings: String,
    pub(super) backend: String,
    same_as: Option<String>,
    /// Reason why it was not measured.
    reason: Option<String>,
    /// [`RowPictures::stem`].
    pub(super) stem: Option<String>,
    has_color: bool,
    has_lookups: bool,
    /// Whether it is on its backend's Pareto front of times, and of costs.
    front: bool,
    front_cost: bool,
    /// Index of its verdicts in the page's list, and whether they are of the same setting apart
    /// from the side of its map.
    verdict: Option<usize>,
    is_own_verdict: bool,
    rmse: Option<f64>,
    rmse_error: Option<f64>,
    mean: Option<f64>,
    false_shadow: Option<f64>,
    false_light: Option<f64>,
    acne: Option<f64>,
    cause_acne: Option<f64>,
    cause_gap: Option<f64>,
    cause_leak: Option<f64>,
    cause_edge: Option<f64>,
    cause_penumbra: Option<f64>,
    /// Number of pixels excluded because the backend sees other triangles there than truth.
    other_triangles: Option<u64>,
    /// Time of a frame, and its counted cost.
    frame: Option<f64>,
    frame_cost: Option<f64>,
    cast: Option<f64>,
    filter: Option<f64>,
    lookup: Option<f64>,
    total: Option<f64>,
    total_least: Option<f64>,
    total_greatest: Option<f64>,
    runs: Option<u32>,
    recipe: Option<f64>,
    scene_once: Option<f64>,
    is_kept: bool,
    yardsticks: Option<f64>,
    /// Whether times were measured at an unknown clock of the device.
    at_unknown_clock: bool,
    bytes: Option<u64>,
    unused: Option<f64>,
    texels: Option<f64>,
    side: Option<u32>,
    compared: Option<u64>,
    differing: Option<u64>,
    largest: Option<f64>,
    violations: Option<u64>,
    by_grid: Option<u64>,
    undecided: Option<u64>,
    elsewhere: Option<u64>,
}

impl PageRow {
    /// Names of the columns with texts.
    pub(super) const TEXTS: [&'static str; 6] = [
        "technique",
        "settings",
        "backend",
        "same_as",
        "reason",
        "stem",
    ];

    pub(super) fn new(
        row: &CompareRow,
        motion: FrameMotion,
        pictures: Option<RowPictures>,
    ) -> Self {
        let pictures = pictures.map(|p| (Some(p.stem), p.color, p.lookups));
        let (stem, has_color, has_lookups) = pictures.unwrap_or_default();
        let named = Self {
            technique: row.technique.clone(),
            settings: row.settings.clone(),
            backend: row.backend.clone(),
            same_as: row.same_as.clone(),
            at_unknown_clock: row.is_at_unknown_clock(),
            stem,
            has_color,
            has_lookups,
            ..Self::default()
        };
        match &row.outcome {
            RowOutcome::Unsupported { reason } => Self {
                reason: Some(reason.clone()),
                ..named
            },
            RowOutcome::Measured(m) => named.with_errors(m).with_times(m, motion).with_rest(m),
        }
    }

    /// Sets whether the row is on its backend's Pareto front of times, and on that of costs.
    pub(super) fn on_fronts(self, by_time: bool, by_cost: bool) -> Self {
        Self {
            front: by_time,
            front_cost: by_cost,
            ..self
        }
    }

    /// Sets the index of its verdicts in the page's list, and whether they are of this very
    /// setting.
    pub(super) fn with_verdict(self, verdict: Option<(usize, bool)>) -> Self {
        Self {
            verdict: verdict.map(|(place, _)| place),
            is_own_verdict: verdict.is_some_and(|(_, is_own)| is_own),
            ..self
        }
    }

    fn with_errors(self, m: &Measured) -> Self {
        Self {
            rmse: m.errors.map(|e| e.rmse),
            rmse_error: m.errors.map(|e| e.rmse_error),
            mean: m.errors.map(|e| e.mean),
            false_shadow: m.errors.map(|e| e.false_shadow),
            false_light: m.errors.map(|e| e.false_light),
            acne: m.errors.map(|e| e.acne),
            other_triangles: m.errors.map(|e| e.elsewhere),
            cause_acne: m.causes.map(|c| c.acne),
            cause_gap: m.causes.map(|c| c.gap),
            cause_leak: m.causes.map(|c| c.leak),
            cause_edge: m.causes.map(|c| c.edge),
            cause_penumbra: m.causes.map(|c| c.penumbra),
            ..self
        }
    }

    fn with_times(self, m: &Measured, motion: FrameMotion) -> Self {
        let stage = |of: fn(&RowTimes) -> Option<TimingStats>| {
            let times = m.times?;
            of(&times).map(|stats| times.milliseconds(&stats))
        };
        let total = m.times.map(|t| t.total);
        Self {
            frame: m.milliseconds(CostBasis::Wall, motion),
            frame_cost: m.milliseconds(CostBasis::Cost, motion),
            cast: stage(|t| t.cast),
            filter: stage(|t| t.filter),
            lookup: stage(|t| t.receive),
            total: stage(|t| Some(t.total)),
            total_least: total.map(|t| t.min),
            total_greatest: total.map(|t| t.max),
            runs: total.map(|t| t.runs),
            recipe: m.preparation.map(|p| p.recipe.median),
            scene_once: m.preparation.map(|p| p.scene_ms),
            is_kept: m.kept_as_camera_moves,
            yardsticks: m.times.and_then(|t| t.ratio).map(|r| r.median),
            ..self
        }
    }

    fn with_rest(self, m: &Measured) -> Self {
        Self {
            bytes: Some(m.bytes),
            unused: m.maps.map(|u| 100.0 * u.unused),
            texels: m.maps.and_then(|u| u.texels).map(f64::from),
            side: m.maps.and_then(|u| u.side),
            compared: m.agreement.map(|a| a.compared),
            differing: m.agreement.map(|a| a.differing),
            largest: m.agreement.map(|a| a.largest),
            violations: m.agreement.map(|a| a.violations),
            by_grid: m.agreement.map(|a| a.by_grid),
            undecided: m.agreement.map(|a| a.undecided),
            elsewhere: m.agreement.map(|a| a.elsewhere),
            ..self
        }
    }
}

/// Distinct texts and their indices.
#[derive(Debug, Default)]
pub(super) struct Texts {
    places: HashMap<String, usize>,
    all: Vec<String>,
}

impl Texts {
    fn place(&mut self, text: &str) -> usize {
        if let Some(&place) = self.places.get(text) {
            return place;
        }
        let place = self.all.len();
        self.all.push(text.to_owned());
        self.places.insert(text.to_owned(), place);
        place
    }

    pub(super) fn into_all(self) -> Vec<String> {
        self.all
    }
}

/// Rows as arrays, with the names of their columns.
pub(super) struct PageTable {
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Vec<Vec<Value>>>,
}

/// Returns the rows of all scenes as arrays.
pub(super) fn table_of<'a>(
    scenes: impl Iterator<Item = &'a [PageRow]>,
    texts: &mut Texts,
) -> serde_json::Result<PageTable> {
    let columns = entries(&PageRow::default())?;
    let columns = columns.into_iter().map(|(name, _)| name).collect();
    let mut rows = Vec::new();
    for scene in scenes {
        let mut of_scene = Vec::with_capacity(scene.len());
        for row in scene {
            let values = entries(row)?.into_iter();
            of_scene.push(values.map(|(_, value)| short(value, texts)).collect());
        }
        rows.push(of_scene);
    }
    Ok(PageTable { columns, rows })
}

/// Returns the fields of a row, always in the same order.
fn entries(row: &PageRow) -> serde_json::Result<Vec<(String, Value)>> {
    match serde_json::to_value(row)? {
        Value::Object(fields) => Ok(fields.into_iter().collect()),
        _ => Ok(Vec::new()),
    }
}

/// Returns a value in fewer letters: texts as their indices, booleans as 0 or 1, figures with few
/// digits.
fn short(value: Value, texts: &mut Texts) -> Value {
    match value {
        Value::String(text) => texts.place(&text).into(),
        Value::Bool(is_so) => u8::from(is_so).into(),
        Value::Number(number) if number.is_f64() => {
            rounded_figure(number.as_f64().unwrap_or_default())
        }
        other => other,
    }
}

/// Rounds to the digits that a reader can use; whole numbers are written without a point.
fn rounded_figure(figure: f64) -> Value {
    let text = format!("{figure:.DIGITS$e}");
    let rounded: f64 = text.parse().unwrap_or(figure);
    if rounded == rounded.trunc() && rounded.abs() < 1e9 {
        return (rounded as i64).into();
    }
    rounded.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_keep_four_digits() {
        let figures =
            [0.123_456, 12_345.6, 0.0, 1.234_56e-7, 3.0].map(|f| rounded_figure(f).to_string());
        assert_eq!(figures, ["0.1235", "12350", "0", "1.235e-7", "3"]);
    }

    #[test]
    fn columns_name_what_rows_hold_and_texts_are_kept_once() {
        let row = |technique: &str| PageRow {
            technique: technique.to_owned(),
            settings: "a".to_owned(),
            rmse: Some(0.25),
            is_kept: true,
            ..PageRow::default()
        };
        let rows = [row("a"), row("b")];
        let mut texts = Texts::default();
        let table = table_of([&rows[..]].into_iter(), &mut texts).expect("plain data");
        let cell = |row: usize, name: &str| {
            let column = table.columns.iter().position(|c| c == name).expect("there");
            table.rows[0][row][column].clone()
        };
        assert_eq!(
            (cell(0, "rmse"), cell(1, "is_kept")),
            (0.25.into(), 1.into())
        );
        assert_eq!(cell(0, "technique"), cell(0, "settings"));
        assert_ne!(cell(0, "technique"), cell(1, "technique"));
        assert_eq!(cell(0, "frame"), Value::Null);
        for name in PageRow::TEXTS {
            assert!(table.columns.iter().any(|c| c == name), "{name}");
        }
        let letters: Vec<String> = texts.into_all();
        assert!(
            letters.len() == 3 && letters.contains(&String::new()),
            "{letters:?}"
        );
    }
}
