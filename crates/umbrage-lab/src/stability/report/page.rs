//! The page: elements, a style sheet, a script, and one block of data.

use crate::{
    LabError,
    output::html::{Page, data_uri},
    stability::{BiasWindow, CaseResult, Stability, sweeps::Sweep},
};
use serde::Serialize;

const BODY: &str = include_str!("body.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

#[derive(Serialize)]
struct Data<'a> {
    stability: &'a Stability,
    /// For each case, for each cell, its picture or nothing.
    pictures: Vec<Vec<Option<String>>>,
    sweeps: Vec<Chart<'a>>,
    /// The windows of bias in words, in the order of the figures.
    windows: Vec<String>,
    /// The sanity cases as one line; none if there are none.
    sanity: Option<String>,
}

#[derive(Serialize)]
struct Chart<'a> {
    name: &'a str,
    svg: String,
}

/// Returns the whole page.
pub(super) fn html(stability: &Stability, sweeps: &[Sweep]) -> Result<String, LabError> {
    let pictures = stability.cases.iter().map(pictures_of).collect();
    let mut charts = Vec::new();
    for sweep in sweeps {
        charts.push(Chart {
            name: &sweep.title,
            svg: data_uri("image/svg+xml", sweep.svg().as_bytes()),
        });
    }
    let data = Data {
        stability,
        pictures,
        sweeps: charts,
        windows: stability.windows.iter().map(BiasWindow::words).collect(),
        sanity: stability.sanity_line(),
    };
    let page = Page {
        title: "umbrage: where shadow methods fail",
        style: STYLE,
        body: BODY,
        scripts: &[SCRIPT],
    };
    page.html(&data)
        .map_err(|e| LabError::write("index.html", e))
}

/// Returns the pictures of a case's cells as data URIs; none for cells without one.
fn pictures_of(case: &CaseResult) -> Vec<Option<String>> {
    let mut out = Vec::new();
    for cell in &case.cells {
        let png = cell.picture.as_deref();
        out.push(png.map(|png| data_uri("image/png", png)));
    }
    out
}
