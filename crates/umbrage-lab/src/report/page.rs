//! The page itself: elements, a style sheet, scripts, and one block of data. Pictures are files
//! beside it.

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
/// In the order in which they run: later ones use what earlier ones declare.
const SCRIPTS: [&str; 7] = [
    include_str!("page/base.js"),
    include_str!("page/verdicts.js"),
    include_str!("page/chart.js"),
    include_str!("page/scenes.js"),
    include_str!("page/groups.js"),
    include_str!("page/rows.js"),
    include_str!("page/start.js"),
];

/// Colours of the error pictures, for people.
const LEGEND: [(&str, &str); 5] = [
    ("#0059cc", "false shadow: darker than truth"),
    ("#ed6600", "false light: lighter than truth"),
    ("#b3b3b3", "left out: faces away from the light"),
    ("#a840b3", "left out: truth is ambiguous"),
    ("#ccd6e3", "nothing receives"),
];

/// A scene as the page shows it.
#[derive(Debug, Serialize)]
pub(super) struct PageScene {
    /// The folder of its pictures, beside the page.
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
    /// What moves, in words.
    pub(super) motion: &'static str,
    pub(super) truth: TruthSummary,
    pub(super) nothing_compared: Option<String>,
    /// RMSE of no shadow.
    pub(super) rmse_of_none: f64,
    /// Negative controls that hold, and all.
    pub(super) controls: [usize; 2],
    /// Of each backend that was timed the rank correlation of counted costs with times.
    pub(super) cost_ranks: Vec<CostRanks>,
    /// In the order of the comparison's rows.
    #[serde(skip)]
    pub(super) rows: Vec<PageRow>,
}

/// How well counted costs rank a scene's rows as the clock does.
#[derive(Debug, Serialize)]
pub(super) struct CostRanks {
    pub(super) backend: String,
    /// -1 to 1.
    pub(super) correlation: f64,
}

/// A setting over the scenes of a group.
#[derive(Debug, Serialize)]
pub(super) struct PageSetting {
    pub(super) technique: String,
    pub(super) settings: String,
    pub(super) error: f64,
    pub(super) time: Option<f64>,
    /// Of the quickest and of the slowest runs.
    pub(super) range: Option<[f64; 2]>,
    pub(super) cost: f64,
    pub(super) served: usize,
    /// Its row of the group's scene that is shown.
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
    /// What to use, in one sentence.
    pub(super) advice: Option<String>,
    /// The scene whose pictures are shown.
    pub(super) scene: usize,
    pub(super) scenes: usize,
    pub(super) settings: Vec<PageSetting>,
    /// Settings shown as pictures, by rising time.
    pub(super) strip: Vec<usize>,
    /// Settings that the sentence names, in its order.
    pub(super) advised: Vec<usize>,
}

/// How a technique looks in charts.
#[derive(Debug, Serialize)]
struct PageStyle {
    marker: String,
    /// A colour for each backend.
    colors: [&'static str; 3],
}

/// All that the page shows.
#[derive(Debug)]
pub(super) struct Contents<'a> {
    pub(super) environment: &'a Environment,
    pub(super) notices: &'a [String],
    pub(super) faults: Vec<String>,
    pub(super) scenes: Vec<PageScene>,
    pub(super) groups: Vec<PageGroup>,
    /// Verdicts to be shown beside each setting.
    pub(super) stability: Option<PageStability>,
    /// What the page is to show first.
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
    /// The names of the columns of `rows`.
    columns: Vec<String>,
    /// For each scene its rows: arrays, which take a third of the space of objects.
    rows: Vec<Vec<Vec<Value>>>,
    /// Texts, to which columns of `text_columns` refer by place.
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

/// Returns the distinct texts, in the order in which they first occur.
fn distinct<'a>(all: impl Iterator<Item = &'a String>) -> Vec<&'a str> {
    let mut out: Vec<&str> = Vec::new();
    for text in all {
        if !out.contains(&text.as_str()) {
            out.push(text);
        }
    }
    out
}

/// Returns how techniques look: as in the still charts.
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

/// Returns a marker's name as the page's script has it.
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
