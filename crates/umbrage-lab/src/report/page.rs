//! The page: elements, a style sheet, scripts, and one block of data. It refers to images as files.

use super::{
    page_rows::{PageRow, Texts, table_of},
    stability_source::PageStability,
    style::{SeriesStyle, styles_of},
};
use crate::{
    compare::{CostBasis, Environment, Section, TruthSummary},
    output::{figure::Marker, html::Page},
};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

const BODY: &str = include_str!("body.html");
const STYLE: &str = include_str!("page.css");
/// Scripts in execution order: later ones use declarations of earlier ones.
const SCRIPTS: [&str; 7] = [
    include_str!("page/base.js"),
    include_str!("page/verdicts.js"),
    include_str!("page/chart.js"),
    include_str!("page/scenes.js"),
    include_str!("page/groups.js"),
    include_str!("page/rows.js"),
    include_str!("page/start.js"),
];

/// Colours of the error images, and their labels.
const LEGEND: [(&str, &str); 5] = [
    ("#0059cc", "false shadow: darker than truth"),
    ("#ed6600", "false light: lighter than truth"),
    ("#b3b3b3", "excluded: faces away from the light"),
    ("#a840b3", "excluded: truth is ambiguous"),
    ("#ccd6e3", "no receiver"),
];

/// A scene for the page.
#[derive(Debug, Serialize)]
pub(super) struct PageScene {
    /// Folder of its images, next to the page.
    pub(super) folder: String,
    pub(super) name: String,
    pub(super) summary: String,
    pub(super) section: Section,
    /// `hard` or `soft`.
    pub(super) shadows: &'static str,
    /// Kind of light.
    pub(super) light: String,
    pub(super) size: [u32; 2],
    pub(super) triangles: u64,
    /// Label of the motion.
    pub(super) motion: &'static str,
    pub(super) truth: TruthSummary,
    pub(super) nothing_compared: Option<String>,
    /// RMSE of no shadow.
    pub(super) rmse_of_none: f64,
    /// Numbers of negative controls that hold, and of all.
    pub(super) controls: [usize; 2],
    /// Rank correlation of counted costs with times, for each timed backend.
    pub(super) cost_ranks: Vec<CostRanks>,
    /// Rows in the order of the comparison.
    #[serde(skip)]
    pub(super) rows: Vec<PageRow>,
}

/// Rank correlation of a scene's counted costs with its times.
#[derive(Debug, Serialize)]
pub(super) struct CostRanks {
    pub(super) backend: String,
    /// Correlation, -1 to 1.
    pub(super) correlation: f64,
}

/// A setting over the scenes of a group.
#[derive(Debug, Serialize)]
pub(super) struct PageSetting {
    pub(super) technique: String,
    pub(super) settings: String,
    pub(super) error: f64,
    pub(super) time: Option<f64>,
    /// Times of the fastest and of the slowest runs.
    pub(super) range: Option<[f64; 2]>,
    pub(super) cost: f64,
    pub(super) served: usize,
    /// Index of its row in the group's shown scene.
    pub(super) row: Option<usize>,
    /// Whether it is on the Pareto front of times, and on that of costs.
    pub(super) front: [bool; 2],
}

/// The settings of one backend over all scenes of one kind of light.
#[derive(Debug, Serialize)]
pub(super) struct PageGroup {
    pub(super) light: &'static str,
    pub(super) backend: String,
    pub(super) subtitle: String,
    /// Recommendation, one sentence.
    pub(super) advice: Option<String>,
    /// Index of the scene whose images are shown.
    pub(super) scene: usize,
    pub(super) scenes: usize,
    pub(super) settings: Vec<PageSetting>,
    /// Settings with images, by increasing time.
    pub(super) strip: Vec<usize>,
    /// Settings that the recommendation names, in its order.
    pub(super) advised: Vec<usize>,
}

/// Marker and colours of a technique in charts.
#[derive(Debug, Serialize)]
struct PageStyle {
    marker: String,
    /// Colour for each backend.
    colors: [&'static str; 3],
}

/// Contents of the page.
#[derive(Debug)]
pub(super) struct Contents<'a> {
    pub(super) environment: &'a Environment,
    pub(super) notices: &'a [String],
    pub(super) faults: Vec<String>,
    pub(super) scenes: Vec<PageScene>,
    pub(super) groups: Vec<PageGroup>,
    /// Verdicts to show for each setting.
    pub(super) stability: Option<PageStability>,
    /// Clock that the page shows first.
    pub(super) clock: CostBasis,
}

#[derive(Serialize)]
struct Data<'a> {
    environment: &'a Environment,
    notices: &'a [String],
    faults: &'a [String],
    clock: &'static str,
    stability: Option<&'a PageStability>,
    scenes: &'a [PageScene],
    groups: &'a [PageGroup],
    backends: Vec<&'a str>,
    styles: BTreeMap<&'a str, PageStyle>,
    legend: [(&'static str, &'static str); 5],
    /// Names of the columns of `rows`.
    columns: Vec<String>,
    /// Rows of each scene as arrays, which take a third of the space of objects.
    rows: Vec<Vec<Vec<Value>>>,
    /// Texts that columns of `text_columns` refer to by index.
    texts: Vec<String>,
    text_columns: [&'static str; 6],
}

/// Returns the whole page.
pub(super) fn html(contents: &Contents<'_>) -> serde_json::Result<String> {
    let mut texts = Texts::default();
    let table = table_of(contents.scenes.iter().map(|s| &s.rows[..]), &mut texts)?;
    let all_rows = || contents.scenes.iter().flat_map(|s| &s.rows);
    let data = Data {
        environment: contents.environment,
        notices: contents.notices,
        faults: &contents.faults,
        clock: match contents.clock {
            CostBasis::Wall => "time",
            CostBasis::Cost => "cost",
        },
        stability: contents.stability.as_ref(),
        scenes: &contents.scenes,
        groups: &contents.groups,
        backends: distinct(all_rows().map(|r| &r.backend)),
        styles: styles(&distinct(all_rows().map(|r| &r.technique))),
        legend: LEGEND,
        columns: table.columns,
        rows: table.rows,
        texts: texts.into_all(),
        text_columns: PageRow::TEXTS,
    };
    let page = Page {
        title: "umbrage: shadows against truth",
        style: STYLE,
        body: BODY,
        scripts: &SCRIPTS,
    };
    page.html(&data)
}

/// Returns the distinct texts, in order of first occurrence.
fn distinct<'a>(all: impl Iterator<Item = &'a String>) -> Vec<&'a str> {
    let mut out: Vec<&str> = Vec::new();
    for text in all {
        if !out.contains(&text.as_str()) {
            out.push(text);
        }
    }
    out
}

/// Returns the styles of techniques, as in the still charts.
fn styles<'a>(techniques: &[&'a str]) -> BTreeMap<&'a str, PageStyle> {
    let styles = techniques.iter().zip(styles_of(techniques));
    styles.map(|(name, style)| (*name, style.into())).collect()
}

impl From<SeriesStyle> for PageStyle {
    fn from(style: SeriesStyle) -> Self {
        Self {
            marker: marker_name(style.marker),
            colors: [0, 1, 2].map(|backend| style.color(backend)),
        }
    }
}

/// Returns a marker's name in the page's script.
fn marker_name(marker: Marker) -> String {
    format!("{marker:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn script_and_style_cannot_end_their_elements() {
        let ends = SCRIPTS.iter().filter(|script| script.contains("</script"));
        assert_eq!(ends.count(), 0);
        assert!(!STYLE.contains("</style"));
    }

    #[test]
    fn the_script_draws_every_marker() {
        let all = SCRIPTS.concat();
        for marker in Marker::ALL {
            let entry = format!("  {}: ", marker_name(marker));
            assert!(all.contains(&entry), "{marker:?}");
        }
    }
}
