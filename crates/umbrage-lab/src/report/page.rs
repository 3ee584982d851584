//! The page itself: elements, a style sheet, a script, and one block of data.

use crate::{
    compare::Comparison,
    output::html::{Page, data_uri},
};
use serde::Serialize;
use std::collections::HashMap;

const BODY: &str = include_str!("body.html");
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
        self.uris.push(data_uri("image/png", png));
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
    let data = Data {
        comparison,
        faults,
        pages,
        overall,
        images: &images.uris,
        legend: LEGEND,
    };
    let title = "umbrage: shadows against truth";
    Page {
        title,
        style: STYLE,
        body: BODY,
        scripts: &[&plotly_source(), SCRIPT],
    }
    .html(&data)
}

/// plotly.js, as the `plotly` crate carries it: the first script of its offline sources; the other sets formulas.
fn plotly_source() -> String {
    let sources = plotly::Plot::offline_js_sources();
    let script = sources.split_once('>').map_or("", |(_, after)| after);
    script
        .split_once("</script>")
        .map_or(script, |(script, _)| script)
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(
            [store.add(b"a"), store.add(b"b"), store.add(b"a")],
            [0, 1, 0]
        );
        assert_eq!(store.uris.len(), 2);
    }
}
