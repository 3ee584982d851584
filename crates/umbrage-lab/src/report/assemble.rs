//! Writes the report of all scenes from their folders. It is the same for one run, for a resumed
//! run, and for merged shards.

use super::{
    chart, chosen,
    page::{self, Contents, CostRanks, PageGroup, PageScene, PageSetting},
    page_rows::{PageRow, RowPictures},
    stability_source::StabilitySource,
    still::{self, GroupWords, StillWords},
    store::{Stored, is_chart},
    table::{lines, to_csv},
    work_table,
};
use crate::{
    compare::{
        CompareRow, Comparison, CostBasis, Environment, Relative, SCHEMA, SceneResult,
        SettingGroup, setting_groups,
    },
    error::LabError,
    output::{csv, folder::Folder},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Number of images in a strip besides truth.
const STRIP: usize = 3;

/// Writes everything but the scenes' own folders, which are in `path`.
pub(super) fn write(
    path: &Path,
    folder: &Folder,
    scenes: &[Stored],
    stability: Option<&StabilitySource>,
) -> Result<(Comparison, PathBuf), LabError> {
    let comparison = comparison(scenes);
    let rows = to_csv(&lines(&comparison))?;
    let json = serde_json::to_vec_pretty(&comparison)
        .map_err(|e| LabError::write(path.join("results.json"), e))?;
    let groups = setting_groups(&comparison);
    let contents = contents(path, scenes, &comparison, &groups, stability);
    let page = page::html(&contents).map_err(|e| LabError::write(path.join("index.html"), e))?;
    folder.write("rows.csv", &rows)?;
    folder.write("work.csv", &work_table::to_csv(&comparison)?)?;
    folder.write("overall.csv", &overall_csv(&groups)?)?;
    folder.write("results.json", &json)?;
    write_charts(path, folder, &groups)?;
    folder.write("index.html", page.as_bytes())?;
    Ok((comparison, path.join("index.html")))
}

/// Returns the name of a group's chart files by a clock, without extension.
fn stem(group: &SettingGroup, clock: CostBasis) -> String {
    let clock = match clock {
        CostBasis::Wall => "time",
        CostBasis::Cost => "cost",
    };
    format!("chart-{clock}-{}-{}", group.light, group.backend)
}

/// Returns the texts of a group's chart.
fn words(group: &SettingGroup, clock: CostBasis) -> StillWords<'static> {
    still::of_group(&GroupWords {
        scenes: group.scenes.len(),
        light: group.light,
        section: group.section,
        motion: group.motion,
        backend: &group.backend,
        clock,
    })
}

/// Returns the contents of the page.
fn contents<'a>(
    path: &Path,
    stored: &[Stored],
    comparison: &'a Comparison,
    groups: &[SettingGroup],
    stability: Option<&StabilitySource>,
) -> Contents<'a> {
    let scenes = stored.iter().map(|s| page_scene(path, s, stability));
    let scenes: Vec<PageScene> = scenes.collect();
    let is_timed = comparison.scenes.iter().any(is_timed);
    let groups = groups.iter().map(|group| page_group(group, comparison));
    Contents {
        environment: &comparison.environment,
        notices: &comparison.notices,
        faults: comparison.faults(),
        groups: groups.collect(),
        scenes,
        stability: stability.map(|source| source.for_page(path, stored)),
        clock: if is_timed {
            CostBasis::Wall
        } else {
            CostBasis::Cost
        },
    }
}

fn is_timed(scene: &SceneResult) -> bool {
    let mut measured = scene.rows.iter().filter_map(CompareRow::measured_figures);
    measured.any(|m| m.times.is_some())
}

/// Returns a group for the page, with the images of its first scene.
pub(super) fn page_group(group: &SettingGroup, comparison: &Comparison) -> PageGroup {
    let scene = group.scenes[0];
    let rows = &comparison.scenes[scene].rows;
    let fronts = [CostBasis::Wall, CostBasis::Cost].map(|clock| group.front(clock));
    let mut settings = Vec::new();
    for (place, setting) in group.settings.iter().enumerate() {
        settings.push(PageSetting {
            technique: setting.technique.clone(),
            settings: setting.settings.clone(),
            error: setting.error,
            time: setting.time.map(|t| t.median),
            range: setting.time.map(|t| [t.min, t.max]),
            cost: setting.cost,
            served: setting.served,
            row: rows.iter().position(|row| is_of(row, setting)),
            front: [0, 1].map(|clock| fronts[clock].contains(&place)),
        });
    }
    PageGroup {
        light: group.light,
        backend: group.backend.clone(),
        subtitle: words(group, group.clock()).subtitle,
        advice: group.advice(),
        scene,
        scenes: group.scenes.len(),
        settings,
        strip: group.shortlist(STRIP),
        advised: group
            .choice()
            .map_or_else(Vec::new, |choice| choice.named_settings()),
    }
}

/// Reports whether a row is a scene's row of a setting.
fn is_of(row: &CompareRow, setting: &Relative) -> bool {
    row.technique == setting.technique
        && row.settings == setting.settings
        && row.backend == setting.backend
}

/// Writes the groups' charts, and removes those of an older run.
fn write_charts(path: &Path, folder: &Folder, groups: &[SettingGroup]) -> Result<(), LabError> {
    let entries = fs::read_dir(path).map_err(|e| LabError::write(path, e))?;
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if is_chart(&name) {
            folder.remove(&name)?;
        }
    }
    for group in groups {
        for clock in [CostBasis::Wall, CostBasis::Cost] {
            let dots = chart::dots(group, clock);
            if dots.is_empty() {
                continue;
            }
            let figure = still::figure(&dots, &words(group, clock));
            let stem = stem(group, clock);
            folder.write(&format!("{stem}.svg"), figure.svg().as_bytes())?;
            folder.write(&format!("{stem}.png"), &figure.png()?)?;
        }
    }
    Ok(())
}

/// Joins the scenes in order. Each notice is kept once.
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

/// Joins environments: the earliest date, the fewest threads, and all distinct values of the other
/// fields.
fn common(all: &[&Environment]) -> Environment {
    let Some(first) = all.first() else {
        return Environment::default();
    };
    Environment {
        version: join_fields(all, |e| Some(&e.version)).unwrap_or_default(),
        commit: join_fields(all, |e| e.commit.as_deref()),
        date: all.iter().filter_map(|e| e.date.clone()).min(),
        cpu: join_fields(all, |e| Some(&e.cpu)).unwrap_or_default(),
        threads: all.iter().map(|e| e.threads).min().unwrap_or_default(),
        system: join_fields(all, |e| Some(&e.system)).unwrap_or_default(),
        adapter: join_fields(all, |e| e.adapter.as_deref()),
        snapping: join_fields(all, |e| e.snapping.as_deref()),
        backends: first.backends.clone(),
    }
}

/// Returns the distinct values of a field, separated by semicolons; `None` if no environment has
/// one.
fn join_fields(all: &[&Environment], field: fn(&Environment) -> Option<&str>) -> Option<String> {
    let mut values: Vec<&str> = Vec::new();
    for value in all.iter().filter_map(|environment| field(environment)) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    (!values.is_empty()).then(|| values.join("; "))
}

/// Returns a scene for the page.
fn page_scene(path: &Path, scene: &Stored, stability: Option<&StabilitySource>) -> PageScene {
    let result = &scene.result;
    let folder = path.join(scene.name());
    let held = result.controls.iter().filter(|c| c.holds).count();
    PageScene {
        folder: scene.name().to_owned(),
        name: result.name.clone(),
        summary: result.summary.clone(),
        section: result.section,
        shadows: if result.is_ideal { "hard" } else { "soft" },
        light: result.light.clone(),
        size: result.size,
        triangles: result.triangles,
        motion: result.motion.words(),
        truth: result.truth.clone(),
        nothing_compared: result.nothing_compared.clone(),
        rmse_of_none: result.error_of_none(),
        controls: [held, result.controls.len()],
        cost_ranks: cost_ranks(result),
        rows: page_rows(&folder, result, stability),
    }
}

/// Returns the rank correlations of a scene's counted costs with its times.
fn cost_ranks(result: &SceneResult) -> Vec<CostRanks> {
    let mut out = Vec::new();
    for backend in result.backends() {
        if let Some(correlation) = result.cost_ranks(backend) {
            out.push(CostRanks {
                backend: backend.to_owned(),
                correlation,
            });
        }
    }
    out
}

/// Returns a scene's rows for the page.
fn page_rows(
    folder: &Path,
    result: &SceneResult,
    stability: Option<&StabilitySource>,
) -> Vec<PageRow> {
    let fronts = [CostBasis::Wall, CostBasis::Cost].map(|clock| chosen::fronts(result, clock));
    let mut out = Vec::with_capacity(result.rows.len());
    for (place, row) in result.rows.iter().enumerate() {
        let page_row = PageRow::new(row, result.motion, pictures(folder, result, row));
        let [by_time, by_cost] = [0, 1].map(|clock| fronts[clock].contains(&place));
        let verdict = stability.and_then(|s| s.place_of(&row.technique, &row.settings));
        out.push(page_row.on_fronts(by_time, by_cost).with_verdict(verdict));
    }
    out
}

/// Returns the images of a row, or of a row with the same mask; `None` without any.
fn pictures(folder: &Path, result: &SceneResult, row: &CompareRow) -> Option<RowPictures> {
    let with_same_mask = result.rows.iter().filter(|other| has_same_mask(row, other));
    let mut all = std::iter::once(row).chain(with_same_mask);
    all.find_map(|row| own_pictures(folder, row))
}

/// Reports whether another row's mask is bit-equal to a row's.
fn has_same_mask(row: &CompareRow, other: &CompareRow) -> bool {
    let is_as_cpu = |r: &CompareRow| {
        let agreement = r.measured_figures().and_then(|m| m.agreement);
        r.backend == "cpu" || agreement.is_some_and(|a| a.differing == 0)
    };
    let is_origin = match &row.same_as {
        Some(origin) => *origin == format!("{} ({})", other.technique, other.settings),
        None => row.slug == other.slug,
    };
    let is_same_backend = row.backend == other.backend;
    is_origin
        && row.measured_figures().is_some()
        && (is_same_backend || is_as_cpu(row) && is_as_cpu(other))
}

/// Returns the images in a scene's folder under a row's name.
fn own_pictures(folder: &Path, row: &CompareRow) -> Option<RowPictures> {
    let stem = row.stem();
    let is_there = |end: &str| folder.join(format!("{stem}{end}.png")).is_file();
    (is_there("") && is_there(".error")).then(|| RowPictures {
        color: is_there(".color"),
        lookups: is_there(".lookups"),
        stem: stem.clone(),
    })
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

/// Returns the table over all scenes, a line per setting and backend.
fn overall_csv(groups: &[SettingGroup]) -> Result<Vec<u8>, LabError> {
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
