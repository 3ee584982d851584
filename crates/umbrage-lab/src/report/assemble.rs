//! Writes the report of all scenes from their folders: the same for one run, one that was stopped and continued, and shards.

use super::{
    chart, lines,
    page::{self, Charts, GroupCharts, ImageStore, RowPictures, ScenePage},
    still::{self, GroupWords, Medium, Words},
    store::Stored,
    to_csv,
};
use crate::{
    LabError,
    compare::{
        Comparison, CostBasis, Environment, Motion, Relative, SCHEMA, Section, relative,
        scene_groups,
    },
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
    let groups = chart_groups(&comparison);
    let mut images = ImageStore::default();
    let mut pages = Vec::new();
    for (index, scene) in scenes.iter().enumerate() {
        pages.push(scene_page(path, index, scene, &mut images));
    }
    let overall: Vec<GroupCharts> = groups.iter().map(ChartGroup::for_page).collect();
    let page = page::html(&comparison, &pages, &overall, &images)
        .map_err(|e| LabError::write(path.join("index.html"), e))?;
    folder.write("rows.csv", &rows)?;
    folder.write("overall.csv", &overall_csv(&groups)?)?;
    folder.write("results.json", &json)?;
    write_charts(path, folder, &groups)?;
    folder.write("index.html", page.as_bytes())?;
    Ok((comparison, path.join("index.html")))
}

/// The settings of one backend over the scenes of one kind of light.
struct ChartGroup {
    light: &'static str,
    section: Section,
    motion: Motion,
    scene_count: usize,
    backend: String,
    settings: Vec<Relative>,
}

/// Returns the groups that get a chart each.
fn chart_groups(comparison: &Comparison) -> Vec<ChartGroup> {
    let mut out = Vec::new();
    for group in scene_groups(comparison) {
        let all = relative(&group.scenes);
        let mut backends: Vec<&str> = Vec::new();
        for setting in &all {
            if !backends.contains(&setting.backend.as_str()) {
                backends.push(&setting.backend);
            }
        }
        for backend in backends {
            let of_backend = all.iter().filter(|r| r.backend == backend);
            out.push(ChartGroup {
                light: group.light(),
                section: group.section,
                motion: group.scenes[0].motion,
                scene_count: group.scenes.len(),
                backend: backend.to_owned(),
                settings: of_backend.cloned().collect(),
            });
        }
    }
    out
}

impl ChartGroup {
    /// Returns the name of the chart's files by a clock, without what comes after the dot.
    fn stem(&self, clock: CostBasis) -> String {
        let clock = match clock {
            CostBasis::Wall => "time",
            CostBasis::Cost => "cost",
        };
        format!("chart-{clock}-{}-{}", self.light, self.backend)
    }

    fn words(&self, clock: CostBasis) -> Words<'static> {
        still::of_group(&GroupWords {
            scenes: self.scene_count,
            light: self.light,
            section: self.section,
            motion: self.motion,
            backend: &self.backend,
            clock,
        })
    }

    fn for_page(&self) -> GroupCharts {
        let words = self.words(CostBasis::Wall);
        GroupCharts {
            title: words.title,
            subtitle: words.subtitle,
            charts: charts(
                |clock| chart::relative_dots(&self.settings, clock),
                |clock| Words {
                    title: String::new(),
                    subtitle: String::new(),
                    ..self.words(clock)
                },
                OVERALL_SIZE,
            ),
        }
    }
}

/// Writes the groups' charts, and removes those of an older run, which would not belong to these data.
fn write_charts(path: &Path, folder: &Folder, groups: &[ChartGroup]) -> Result<(), LabError> {
    let entries = fs::read_dir(path).map_err(|e| LabError::write(path, e))?;
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with("chart-") {
            folder.remove(&name)?;
        }
    }
    for group in groups {
        for clock in [CostBasis::Wall, CostBasis::Cost] {
            let dots = chart::relative_dots(&group.settings, clock);
            if dots.is_empty() {
                continue;
            }
            let figure = still::figure(&dots, &group.words(clock), Medium::Still);
            let stem = group.stem(clock);
            folder.write(&format!("{stem}.svg"), figure.svg().as_bytes())?;
            folder.write(&format!("{stem}.png"), &figure.png()?)?;
        }
    }
    Ok(())
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
            |clock| still::of_scene(clock, result.motion),
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

const OVERALL_HEADER: [&str; 11] = [
    "light",
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
fn overall_csv(groups: &[ChartGroup]) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for group in groups {
        for r in &group.settings {
            lines.push([
                group.light.to_owned(),
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
    }
    csv::of_lines("overall.csv", &OVERALL_HEADER, lines)
}

fn or_empty(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}
