//! The page itself: a template, a style sheet, a script, and one block of data.

use crate::compare::Comparison;
use base64::{Engine, engine::general_purpose::STANDARD};
use serde::Serialize;
use std::collections::HashMap;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Colours of the error pictures, for people.
const LEGEND: [(&str, &str); 5] = [
    ("#0059cc", "false shadow: darker than truth"),
    ("#ed6600", "false light: lighter than truth"),
    ("#b3b3b3", "left out: faces away from the light"),
    ("#a840b3", "left out: truth is ambiguous"),
    ("#ccd6e3", "nothing receives"),
];

/// Pictures as data URIs, each once.
#[derive(Debug, Default)]
pub(super) struct ImageStore {
    uris: Vec<String>,
    ids: HashMap<Vec<u8>, usize>,
}

impl ImageStore {
    /// The number of a PNG, old or new.
    pub(super) fn add(&mut self, png: &[u8]) -> usize {
        if let Some(&id) = self.ids.get(png) {
            return id;
        }
        let id = self.uris.len();
        self.uris.push(format!("data:image/png;base64,{}", STANDARD.encode(png)));
        self.ids.insert(png.to_vec(), id);
        id
    }
}

/// Numbers of a row's pictures.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct RowPictures {
    pub(super) mask: usize,
    pub(super) error: usize,
    pub(super) color: Option<usize>,
    pub(super) lookups: Option<usize>,
}

/// What the page needs of a scene beyond its figures.
#[derive(Debug, Serialize)]
pub(super) struct ScenePage {
    pub(super) index: usize,
    pub(super) truth: Option<usize>,
    pub(super) rows: Vec<Option<RowPictures>>,
    pub(super) charts: Charts,
}

/// A chart by each clock that there is.
#[derive(Debug, Serialize)]
pub(super) struct Charts {
    pub(super) time: Option<Chart>,
    pub(super) cost: Option<Chart>,
}

/// One chart.
#[derive(Debug, Serialize)]
pub(super) struct Chart {
    /// Rows on their backend's Pareto front.
    pub(super) front: Vec<usize>,
    /// The curves.
    pub(super) traces: serde_json::Value,
}

#[derive(Serialize)]
struct Data<'a> {
    comparison: &'a Comparison,
    faults: Vec<String>,
    pages: &'a [ScenePage],
    overall: &'a Charts,
    images: &'a [String],
    legend: [(&'static str, &'static str); 5],
}

/// The whole page.
pub(super) fn html(
    comparison: &Comparison,
    pages: &[ScenePage],
    overall: &Charts,
    images: &ImageStore,
) -> serde_json::Result<String> {
    let faults = comparison.faults();
    let data = Data { comparison, faults, pages, overall, images: &images.uris, legend: LEGEND };
    let data = for_script(&serde_json::to_string(&data)?);
    let plotly = plotly_source();
    Ok(fill(&[("{{style}}", STYLE), ("{{data}}", &data), ("{{plotly}}", &plotly), ("{{script}}", SCRIPT)]))
}

/// Fills the template's marks, which come in this order, without looking at what was filled in.
fn fill(parts: &[(&str, &str)]) -> String {
    let (mut rest, mut out) = (TEMPLATE, String::new());
    for (mark, text) in parts {
        if let Some((before, after)) = rest.split_once(mark) {
            out.push_str(before);
            out.push_str(text);
            rest = after;
        }
    }
    out + rest
}

/// JSON that no script element ends within: `<` is written as an escape.
fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// plotly.js, as the `plotly` crate carries it: the first script of its offline sources; the other sets formulas.
fn plotly_source() -> String {
    let sources = plotly::Plot::offline_js_sources();
    let script = sources.split_once('>').map_or("", |(_, after)| after);
    script.split_once("</script>").map_or(script, |(script, _)| script).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_template_has_every_mark_once_and_in_order() {
        let places: Vec<usize> = ["{{style}}", "{{data}}", "{{plotly}}", "{{script}}"]
            .iter()
            .map(|mark| {
                assert_eq!(TEMPLATE.matches(mark).count(), 1, "{mark}");
                TEMPLATE.find(mark).expect("just counted")
            })
            .collect();
        assert!(places.is_sorted());
    }

    #[test]
    fn plotly_is_there_once_and_cannot_end_its_element() {
        let source = plotly_source();
        assert!(source.len() > 1_000_000 && source.contains("plotly.js v"));
        assert!(!source.contains("</script"));
        assert!(!SCRIPT.contains("</script") && !STYLE.contains("</style"));
    }

    #[test]
    fn equal_pictures_are_kept_once() {
        let mut store = ImageStore::default();
        assert_eq!([store.add(b"a"), store.add(b"b"), store.add(b"a")], [0, 1, 0]);
        assert_eq!(store.uris.len(), 2);
    }
}
