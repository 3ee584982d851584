//! The page: elements, a style sheet, a script, and one block of data.

use crate::{
    LabError,
    output::html::{Page, data_uri},
    stability::{Stability, sweeps::Sweep},
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
}

#[derive(Serialize)]
struct Chart<'a> {
    name: &'a str,
    svg: String,
}

/// The whole page.
pub(super) fn html(stability: &Stability, sweeps: &[Sweep]) -> Result<String, LabError> {
    let pictures = stability.cases.iter().map(|case| {
        case.cells
            .iter()
            .map(|cell| {
                cell.picture
                    .as_deref()
                    .map(|png| data_uri("image/png", png))
            })
            .collect()
    });
    let charts = sweeps.iter().map(|s| Chart {
        name: &s.title,
        svg: data_uri("image/svg+xml", s.svg().as_bytes()),
    });
    let data = Data {
        stability,
        pictures: pictures.collect(),
        sweeps: charts.collect(),
    };
    let title = "umbrage: where shadow methods fail";
    let page = Page {
        title,
        style: STYLE,
        body: BODY,
        scripts: &[SCRIPT],
    }
    .html(&data);
    page.map_err(|e| LabError::write("index.html", e))
}
