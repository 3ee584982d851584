//! The page: elements, a style sheet, a script, and one block of data.

use crate::{
    LabError,
    output::html::Page,
    stability::{Stability, sweeps::Sweep},
};
use base64::{Engine, engine::general_purpose::STANDARD};
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
    let uri =
        |kind: &str, bytes: &[u8]| format!("data:image/{kind};base64,{}", STANDARD.encode(bytes));
    let pictures = stability.cases.iter().map(|case| {
        case.cells
            .iter()
            .map(|cell| cell.picture.as_deref().map(|png| uri("png", png)))
            .collect()
    });
    let charts = sweeps.iter().map(|s| Chart {
        name: &s.title,
        svg: uri("svg+xml", s.svg().as_bytes()),
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
    page.map_err(|e| LabError::Write {
        path: "index.html".into(),
        source: e.into(),
    })
}
