//! The page: elements, a style sheet, scripts, and one block of data. It refers to images and
//! charts as files.

use super::{SWEEPS, results::StabilityResults};
use crate::{
    compare::Environment,
    error::LabError,
    output::html::Page,
    stability::{bias_window::BiasWindow, cell::Stability, setting_verdicts::SettingVerdicts},
};
use serde::Serialize;

const BODY: &str = include_str!("body.html");
const STYLE: &str = include_str!("page.css");
/// Scripts in execution order: later ones use declarations of earlier ones.
const SCRIPTS: [&str; 3] = [
    include_str!("base.js"),
    include_str!("matrix.js"),
    include_str!("page.js"),
];

#[derive(Serialize)]
struct Data<'a> {
    environment: &'a Environment,
    stability: &'a Stability,
    /// Image file of each cell of each case, or nothing.
    pictures: &'a Vec<Vec<Option<String>>>,
    sweeps: Vec<Chart<'a>>,
    windows: Vec<Window<'a>>,
    /// Summary of the bias windows, one or two sentences; `None` without windows.
    headline: Option<String>,
    /// Verdicts over all rows for each setting.
    verdicts: Vec<SettingVerdicts>,
    /// One line about the sanity cases; `None` if there are none.
    sanity: Option<String>,
}

#[derive(Serialize)]
struct Chart<'a> {
    name: &'a str,
    file: String,
}

/// A bias window and its label.
#[derive(Serialize)]
struct Window<'a> {
    #[serde(flatten)]
    window: &'a BiasWindow,
    words: String,
}

/// Returns the whole page.
pub(super) fn html(results: &StabilityResults) -> Result<String, LabError> {
    let stability = &results.stability;
    let mut charts = Vec::new();
    for sweep in &results.sweeps {
        charts.push(Chart {
            name: &sweep.title,
            file: format!("{SWEEPS}/{}.svg", sweep.name),
        });
    }
    let windows = stability.windows.iter().map(|window| Window {
        window,
        words: window.words(),
    });
    let data = Data {
        environment: &results.environment,
        stability,
        pictures: &results.pictures,
        sweeps: charts,
        windows: windows.collect(),
        headline: stability.windows_line(),
        verdicts: stability.setting_verdicts(),
        sanity: stability.sanity_line(),
    };
    let page = Page {
        title: "umbrage: where shadow methods fail",
        style: STYLE,
        body: BODY,
        scripts: &SCRIPTS,
    };
    page.html(&data)
        .map_err(|e| LabError::write("index.html", e))
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

    /// Every element that a script looks up by name is in the body, or made by a script.
    #[test]
    fn scripts_find_their_elements() {
        let all = SCRIPTS.concat();
        for part in all.split("byId(\"").skip(1) {
            let id = part.split('"').next().unwrap_or_default();
            let is_there = BODY.contains(&format!("id=\"{id}\""));
            assert!(is_there || all.contains(&format!("id: \"{id}\"")), "{id}");
        }
    }
}
