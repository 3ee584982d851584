//! The page itself: elements, a style sheet, a script, and one block of data.

use super::{
    chart::{self, Dot},
    still::{self, Medium, Words},
};
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
    /// Adds a PNG unless it is there already, and returns its index.
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

/// Indices of a row's pictures in the [`ImageStore`].
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

/// The charts of one backend over all scenes of one kind of light.
#[derive(Debug, Serialize)]
pub(super) struct GroupCharts {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) charts: Charts,
}

/// One chart.
#[derive(Debug, Serialize)]
pub(super) struct Chart {
    /// Rows on their backend's Pareto front.
    pub(super) front: Vec<usize>,
    /// The drawing, of [`crate::output::figure::Figure::svg_for_page`]. A point's title is its place among the dots.
    pub(super) svg: String,
    /// What the points are.
    pub(super) dots: Vec<Dot>,
}

impl Chart {
    /// Draws dots at a size in pixels of the SVG.
    pub(super) fn new(dots: Vec<Dot>, words: &Words<'_>, size: [f64; 2]) -> Self {
        let mut figure = still::figure(&dots, words, Medium::Page);
        figure.size = size;
        Self {
            front: chart::front(&dots),
            svg: figure.svg_for_page(),
            dots,
        }
    }
}

#[derive(Serialize)]
struct Data<'a> {
    comparison: &'a Comparison,
    faults: Vec<String>,
    pages: &'a [ScenePage],
    overall: &'a [GroupCharts],
    images: &'a [String],
    legend: [(&'static str, &'static str); 5],
}

/// Returns the whole page.
pub(super) fn html(
    comparison: &Comparison,
    pages: &[ScenePage],
    overall: &[GroupCharts],
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
    let page = Page {
        title: "umbrage: shadows against truth",
        style: STYLE,
        body: BODY,
        scripts: &[SCRIPT],
    };
    page.html(&data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn script_and_style_cannot_end_their_elements() {
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
