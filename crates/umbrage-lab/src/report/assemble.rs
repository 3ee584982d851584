//! From scenes on disk to the report of all: the same for one run, for one that was stopped and went on, and for shards.

use super::{
    chart, lines,
    page::{self, Charts, ImageStore, RowPictures, ScenePage},
    still::{self, Medium, Words},
    store::Stored,
    to_csv,
};
use crate::{
    LabError,
    compare::{Comparison, CostBasis, Environment, Relative, SCHEMA, TimingStats, relative},
    output::{Folder, csv},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Width and height of the page's chart over all scenes, and of a scene's, pixels of the SVG; the page scales them.
const OVERALL_SIZE: [f64; 2] = [1240.0, 560.0];
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
    let pages = scenes
        .iter()
        .enumerate()
        .map(|(i, s)| scene_page(path, i, s, &mut images))
        .collect::<Vec<_>>();
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
            // An older run's would not belong to these data.
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

/// The scenes together, in their order, with what is common to them.
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

/// The earliest date; of everything else what was met, joined where it differs.
fn common(all: &[&Environment]) -> Environment {
    let Some(first) = all.first() else {
        return Environment::default();
    };
    let joined = |of: fn(&Environment) -> Option<&str>| {
        let mut met: Vec<&str> = Vec::new();
        all.iter().filter_map(|e| of(e)).for_each(|v| {
            if !met.contains(&v) {
                met.push(v)
            }
        });
        (!met.is_empty()).then(|| met.join("; "))
    };
    Environment {
        version: joined(|e| Some(&e.version)).unwrap_or_default(),
        commit: joined(|e| e.commit.as_deref()),
        date: all.iter().filter_map(|e| e.date.clone()).min(),
        cpu: joined(|e| Some(&e.cpu)).unwrap_or_default(),
        threads: all.iter().map(|e| e.threads).min().unwrap_or_default(),
        system: joined(|e| Some(&e.system)).unwrap_or_default(),
        adapter: joined(|e| e.adapter.as_deref()),
        snapping: joined(|e| e.snapping.as_deref()),
        backends: first.backends.clone(),
    }
}

/// A scene's part of the page, its pictures read back from its folder.
fn scene_page(path: &Path, index: usize, scene: &Stored, images: &mut ImageStore) -> ScenePage {
    let folder = path.join(scene.name());
    let result = &scene.result;
    let mut add = |name: String| fs::read(folder.join(name)).ok().map(|png| images.add(&png));
    let truth = add("truth.png".to_owned());
    let mut row = |stem: String| {
        let (mask, error) = (
            add(format!("{stem}.png"))?,
            add(format!("{stem}.error.png"))?,
        );
        Some(RowPictures {
            mask,
            error,
            color: add(format!("{stem}.color.png")),
            lookups: add(format!("{stem}.lookups.png")),
        })
    };
    let rows = result.rows.iter().map(|r| row(r.stem())).collect();
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

/// Returns the page's charts by each clock for which there are dots.
fn charts(
    dots: impl Fn(CostBasis) -> Vec<chart::Dot>,
    words: impl Fn(CostBasis) -> Words<'static>,
    size: [f64; 2],
) -> Charts {
    let chart = |clock| {
        let dots = dots(clock);
        (!dots.is_empty()).then(|| page::Chart::new(dots, &words(clock), size))
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

/// One line a setting and backend.
fn overall_csv(all: &[Relative]) -> Result<Vec<u8>, LabError> {
    let lines = all.iter().map(|r| {
        let time = |of: fn(&TimingStats) -> f64| {
            r.time.as_ref().map_or(String::new(), |t| of(t).to_string())
        };
        [
            r.technique.clone(),
            r.settings.clone(),
            r.backend.clone(),
            r.error.to_string(),
            time(|t| t.median),
            time(|t| t.min),
            time(|t| t.max),
            r.cost.to_string(),
            r.served.to_string(),
            r.scenes.to_string(),
        ]
    });
    csv::of_lines("overall.csv", &OVERALL_HEADER, lines)
}
