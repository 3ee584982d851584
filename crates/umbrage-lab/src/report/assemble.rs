//! Writes the report of all scenes from their folders: the same for one run, one that was stopped and continued, and shards.

use super::{
    chart, lines,
    page::{self, Charts, ImageStore, RowPictures, ScenePage},
    still::{self, Medium, Words},
    store::Stored,
    to_csv,
};
use crate::{
    LabError,
    compare::{Comparison, CostBasis, Environment, Relative, SCHEMA, relative},
    output::{Folder, csv},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Width and height of the page's chart over all scenes, pixels of the SVG; the page scales it.
const OVERALL_SIZE: [f64; 2] = [1240.0, 560.0];
/// Width and height of the page's chart of a scene, pixels of the SVG; the page scales it.
const SCENE_SIZE: [f64; 2] = [1000.0, 480.0];

/// Writes everything but the scenes' own folders, which lie in `path`.
pub(super) fn write(
    path: &Path,
    folder: &Folder,
    scenes: &[Stored],
) -> Result<(Comparison, PathBuf), LabError> {
    let comparison = comparison(scenes);
    let rows = to_csv(&lines(&comparison))?;
    let json = serde_json::to_vec_pretty(&comparison)
        .map_err(|e| LabError::write(path.join("results.json"), e))?;
    let all = relative(&comparison);
    let mut images = ImageStore::default();
    let mut pages = Vec::new();
    for (index, scene) in scenes.iter().enumerate() {
        pages.push(scene_page(path, index, scene, &mut images));
    }
    let scene_count = all.iter().map(|r| r.scenes).max().unwrap_or(0);
    let overall = charts(
        |clock| chart::relative_dots(&all, clock),
        |clock| Words {
            title: "",
            subtitle: String::new(),
            ..still::of_all(scene_count, clock)
        },
        OVERALL_SIZE,
    );
    let page = page::html(&comparison, &pages, &overall, &images)
        .map_err(|e| LabError::write(path.join("index.html"), e))?;
    folder.write("rows.csv", &rows)?;
    folder.write("overall.csv", &overall_csv(&all)?)?;
    folder.write("results.json", &json)?;
    for (name, clock) in [("time", CostBasis::Wall), ("cost", CostBasis::Cost)] {
        let dots = chart::relative_dots(&all, clock);
        if dots.is_empty() {
            // The chart of an older run would not belong to these data.
            folder.remove(&format!("chart-{name}.svg"))?;
            folder.remove(&format!("chart-{name}.png"))?;
        } else {
            let words = still::of_all(scene_count, clock);
            let figure = still::figure(&dots, &words, Medium::Still);
            folder.write(&format!("chart-{name}.svg"), figure.svg().as_bytes())?;
            folder.write(&format!("chart-{name}.png"), &figure.png()?)?;
        }
    }
    folder.write("index.html", page.as_bytes())?;
    Ok((comparison, path.join("index.html")))
}

/// Joins the scenes, in their order. Each notice is kept once.
fn comparison(scenes: &[Stored]) -> Comparison {
    let mut notices: Vec<String> = Vec::new();
    for notice in scenes.iter().flat_map(|s| &s.notices) {
        if !notices.contains(notice) {
            notices.push(notice.clone());
        }
    }
    let environment = common(&scenes.iter().map(|s| &s.environment).collect::<Vec<_>>());
    Comparison {
        schema: SCHEMA,
        environment,
        notices,
        scenes: scenes.iter().map(|s| s.result.clone()).collect(),
    }
}

/// Joins environments: the earliest date and the fewest threads; of everything else all values, joined where they differ.
fn common(all: &[&Environment]) -> Environment {
    let Some(first) = all.first() else {
        return Environment::default();
    };
    Environment {
        version: joined(all, |e| Some(&e.version)).unwrap_or_default(),
        commit: joined(all, |e| e.commit.as_deref()),
        date: all.iter().filter_map(|e| e.date.clone()).min(),
        cpu: joined(all, |e| Some(&e.cpu)).unwrap_or_default(),
        threads: all.iter().map(|e| e.threads).min().unwrap_or_default(),
        system: joined(all, |e| Some(&e.system)).unwrap_or_default(),
        adapter: joined(all, |e| e.adapter.as_deref()),
        snapping: joined(all, |e| e.snapping.as_deref()),
        backends: first.backends.clone(),
    }
}

/// Returns the distinct values of a field, separated by semicolons; none if no environment has one.
fn joined(all: &[&Environment], field: fn(&Environment) -> Option<&str>) -> Option<String> {
    let mut values: Vec<&str> = Vec::new();
    for value in all.iter().filter_map(|environment| field(environment)) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    (!values.is_empty()).then(|| values.join("; "))
}

/// Returns a scene's part of the page, its pictures read back from its folder.
fn scene_page(path: &Path, index: usize, scene: &Stored, images: &mut ImageStore) -> ScenePage {
    let folder = path.join(scene.name());
    let result = &scene.result;
    let truth = add_image(&folder, "truth.png", images);
    let rows = result
        .rows
        .iter()
        .map(|row| row_pictures(&folder, &row.stem(), images))
        .collect();
    ScenePage {
        index,
        truth,
        rows,
        charts: charts(
            |clock| chart::dots(result, clock),
            still::of_scene,
            SCENE_SIZE,
        ),
    }
}

/// Adds a row's pictures; none if the row has none.
fn row_pictures(folder: &Path, stem: &str, images: &mut ImageStore) -> Option<RowPictures> {
    let mask = add_image(folder, &format!("{stem}.png"), images)?;
    let error = add_image(folder, &format!("{stem}.error.png"), images)?;
    let color = add_image(folder, &format!("{stem}.color.png"), images);
    let lookups = add_image(folder, &format!("{stem}.lookups.png"), images);
    Some(RowPictures {
        mask,
        error,
        color,
        lookups,
    })
}

/// Adds a picture to the page and returns its index there; none if there is no such file.
fn add_image(folder: &Path, name: &str, images: &mut ImageStore) -> Option<usize> {
    let png = fs::read(folder.join(name)).ok()?;
    Some(images.add(&png))
}

/// Returns the page's charts by each clock for which there are dots.
fn charts(
    dots: impl Fn(CostBasis) -> Vec<chart::Dot>,
    words: impl Fn(CostBasis) -> Words<'static>,
    size: [f64; 2],
) -> Charts {
    let chart = |clock| {
        let dots = dots(clock);
        if dots.is_empty() {
            return None;
        }
        Some(page::Chart::new(dots, &words(clock), size))
    };
    Charts {
        time: chart(CostBasis::Wall),
        cost: chart(CostBasis::Cost),
    }
}

const OVERALL_HEADER: [&str; 10] = [
    "technique",
    "settings",
    "backend",
    "error",
    "time",
    "time_least",
    "time_greatest",
    "cost",
    "served",
    "scenes",
];

/// Returns the table over all scenes, a line for each setting and backend.
fn overall_csv(all: &[Relative]) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for r in all {
        lines.push([
            r.technique.clone(),
            r.settings.clone(),
            r.backend.clone(),
            r.error.to_string(),
            or_empty(r.time.map(|t| t.median)),
            or_empty(r.time.map(|t| t.min)),
            or_empty(r.time.map(|t| t.max)),
            r.cost.to_string(),
            r.served.to_string(),
            r.scenes.to_string(),
        ]);
    }
    csv::of_lines("overall.csv", &OVERALL_HEADER, lines)
}

fn or_empty(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}
