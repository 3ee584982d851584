//! The page: a template, a style sheet, a script, and one block of data.

use crate::{
    LabError,
    stability::{Stability, sweeps::Sweep},
};
use base64::{Engine, engine::general_purpose::STANDARD};
use serde::Serialize;

const TEMPLATE: &str = include_str!("page.html");
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
    let uri = |kind: &str, bytes: &[u8]| format!("data:image/{kind};base64,{}", STANDARD.encode(bytes));
    let pictures = stability
        .cases
        .iter()
        .map(|case| case.cells.iter().map(|cell| cell.picture.as_deref().map(|png| uri("png", png))).collect());
    let charts = sweeps.iter().map(|s| Chart { name: &s.title, svg: uri("svg+xml", s.svg().as_bytes()) });
    let data = Data { stability, pictures: pictures.collect(), sweeps: charts.collect() };
    let json = serde_json::to_string(&data);
    let json = json.map_err(|e| LabError::Write { path: "index.html".into(), source: e.into() })?;
    // No script element ends within: `<` is written as an escape.
    let json = json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029");
    let parts = [("{{style}}", STYLE), ("{{data}}", &json), ("{{script}}", SCRIPT)];
    let fill = |(mut out, rest): (String, &'static str), (mark, part): (&str, &str)| {
        let (before, after) = rest.split_once(mark).unwrap_or((rest, ""));
        out.push_str(before);
        out.push_str(part);
        (out, after)
    };
    let (page, rest) = parts.into_iter().fold((String::new(), TEMPLATE), fill);
    Ok(page + rest)
}
