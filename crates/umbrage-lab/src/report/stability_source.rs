//! Results of `stability`, shown with a comparison's settings.

use super::store::Stored;
use crate::{
    compare::Environment,
    stability::{SettingVerdicts, nearest, report::StabilityResults},
};
use serde::Serialize;
use std::path::{Component, Path, PathBuf};
use umbrage_core::Invalid;

/// Results of `stability`, to show with a comparison's settings.
#[derive(Clone, Debug)]
pub struct StabilitySource {
    /// Folder that it wrote.
    folder: PathBuf,
    verdicts: Vec<SettingVerdicts>,
    /// Description of the run: number of rows, map and image size, backends.
    description: String,
    program: String,
    commit: Option<String>,
}

/// Results of `stability` for the page.
#[derive(Debug, Serialize)]
pub(super) struct PageStability {
    /// Relative address of `stability`'s page; `None` if there is no such page.
    href: Option<String>,
    #[serde(rename = "told")]
    description: String,
    /// Reason why the verdicts may be of other code than the compared one; `None` if they aren't.
    stale: Option<String>,
    pub(super) verdicts: Vec<SettingVerdicts>,
}

impl StabilitySource {
    /// Reads the folder that `stability` wrote, or the `results.json` in it.
    ///
    /// # Errors
    /// Errors if it can't be read, or another version wrote it.
    pub fn read(path: &Path) -> Result<Self, Invalid> {
        let results = StabilityResults::read(path)?;
        let folder = if path.is_dir() {
            path
        } else {
            path.parent().unwrap_or(Path::new("."))
        };
        Ok(Self::new(&results, folder))
    }

    /// Returns the verdicts of results in a folder.
    pub(super) fn new(results: &StabilityResults, folder: &Path) -> Self {
        let stability = &results.stability;
        let mut rows: Vec<u8> = stability.separating_cases().map(|case| case.row).collect();
        rows.dedup();
        let count = rows.len();
        let [w, h] = stability.size;
        let side = stability.map_size;
        let backends = stability.backends.join(" and ");
        Self {
            folder: folder.to_owned(),
            verdicts: stability.setting_verdicts(),
            description: format!(
                "{count} rows, maps of {side} texels, images of {w} x {h}, on {backends}"
            ),
            program: results.program.clone(),
            commit: results.environment.commit.clone(),
        }
    }

    /// Returns a description of the run: number of rows, map and image size, backends.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Returns the verdicts that apply to a setting: see [`nearest`]. `None` if it was not run with
    /// that bias.
    pub fn verdicts_of(&self, technique: &str, settings: &str) -> Option<&SettingVerdicts> {
        let of_technique = nearest(&self.verdicts, technique, settings);
        // A preset's row has the preset's name; its settings start with the technique's name.
        let of_preset = || {
            let (technique, settings) = settings.split_once(", ")?;
            nearest(&self.verdicts, technique, settings)
        };
        of_technique.or_else(of_preset)
    }

    /// Returns the index of [`Self::verdicts_of`] among the page's verdicts, and whether they are
    /// of the very setting.
    pub(super) fn place_of(&self, technique: &str, settings: &str) -> Option<(usize, bool)> {
        let found = self.verdicts_of(technique, settings)?;
        let place = self.verdicts.iter().position(|v| v == found)?;
        let of_preset = format!("{}, ", found.technique);
        let own = settings.strip_prefix(&of_preset).unwrap_or(settings);
        let is_own = found.is_of(&found.technique, own);
        Some((place, is_own))
    }

    /// Returns the data for a page in this folder.
    pub(super) fn for_page(&self, report: &Path, scenes: &[Stored]) -> PageStability {
        let has_page = self.folder.join("index.html").is_file();
        let href = has_page.then(|| relative(report, &self.folder)).flatten();
        PageStability {
            href: href.map(|folder| format!("{folder}/index.html")),
            description: self.description.clone(),
            stale: self.stale(scenes),
            verdicts: self.verdicts.clone(),
        }
    }

    /// Returns the reason why the verdicts may be of other code than the scenes; `None` if one
    /// program measured both.
    fn stale(&self, scenes: &[Stored]) -> Option<String> {
        let mut scenes = scenes.iter();
        scenes.find_map(|scene| self.stale_against(&scene.program, &scene.environment))
    }

    /// Returns the reason why the verdicts may be of other code than this program in this
    /// environment; `None` if it measured them.
    pub(crate) fn stale_against(&self, program: &str, environment: &Environment) -> Option<String> {
        if program == self.program {
            return None;
        }
        let name = |commit: &Option<String>| match commit {
            Some(commit) => format!("commit {commit}"),
            None => "an unknown commit".to_owned(),
        };
        let [rendered, measured] = [&self.commit, &environment.commit].map(name);
        Some(if rendered == measured {
            format!("measured by another build of {rendered} than these rows")
        } else {
            format!("measured at {rendered}, these rows at {measured}")
        })
    }
}

/// Returns the relative path from one folder to another, with `/` between names as in web
/// addresses. `None` if they are on different drives or don't exist.
fn relative(from: &Path, to: &Path) -> Option<String> {
    let from = from.canonicalize().ok()?;
    let to = to.canonicalize().ok()?;
    let from: Vec<Component<'_>> = from.components().collect();
    let to: Vec<Component<'_>> = to.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return None;
    }
    let mut parts = vec!["..".to_owned(); from.len() - shared];
    for component in &to[shared..] {
        parts.push(component.as_os_str().to_string_lossy().into_owned());
    }
    Some(if parts.is_empty() {
        ".".to_owned()
    } else {
        parts.join("/")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        report::{
            merge,
            tests::{NASTY, plan, write},
        },
        stability::{
            CaseResult, Cell, CellOutcome, Judgement, Stability, Verdict, report::STABILITY_SCHEMA,
        },
    };
    use serde_json::Value;
    use std::fs;

    /// Returns results in which technique `quick`, with the settings of the synthetic comparison,
    /// fails the second of two rows; `good` was run with other settings.
    fn results() -> StabilityResults {
        let cell = |technique: &str, settings: &str, verdict| Cell {
            technique: technique.to_owned(),
            settings: settings.to_owned(),
            outcome: CellOutcome::from_judgements(vec![Judgement {
                figure: Some(1.0),
                verdict,
                reason: None,
            }]),
            disagreeing: None,
            picture: None,
        };
        let case = |row: u8, verdict| CaseResult {
            row,
            title: format!("row {row} <b>"),
            weakness: String::new(),
            not_yet: None,
            case: format!("case-{row}"),
            scene: String::new(),
            motion: "still".to_owned(),
            fit: String::new(),
            is_sanity: false,
            criteria: Vec::new(),
            cells: vec![
                cell("good", "bias: another", verdict),
                cell("quick", NASTY, verdict),
            ],
        };
        StabilityResults {
            schema: STABILITY_SCHEMA,
            stability: Stability {
                cases: vec![case(1, Verdict::Pass), case(2, Verdict::Fails)],
                ..Stability::default()
            },
            ..StabilityResults::default()
        }
    }

    /// Returns the data of a report's page with these verdicts.
    fn page_with(source: Option<&StabilitySource>) -> Value {
        let (dir, _) = write(false);
        let merged = dir.path().join("merged");
        let folders = [dir.path().join("out")];
        merge(&folders, &merged, source).expect("all there");
        let page = fs::read_to_string(merged.join("index.html")).expect("there");
        let (_, rest) = page.split_once("id=\"data\">").expect("there");
        let (json, _) = rest.split_once("</script>").expect("there");
        serde_json::from_str(json).expect("valid")
    }

    /// Returns a row's value in a column of the first scene.
    fn value(data: &Value, row: usize, name: &str) -> Value {
        let columns = data["columns"].as_array().expect("names");
        let place = columns.iter().position(|column| column == name);
        data["rows"][0][row][place.expect("a column")].clone()
    }

    #[test]
    fn the_page_has_verdicts_next_to_the_settings_that_were_rendered() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        fs::write(dir.path().join("index.html"), "").expect("writable");
        let source = StabilitySource::new(&results(), dir.path());
        let data = page_with(Some(&source));
        // The synthetic rows are of `good`, `quick`, `beaten` and `dash`.
        assert_eq!(value(&data, 0, "verdict"), Value::Null);
        assert_eq!(value(&data, 1, "verdict"), 1);
        assert_eq!(value(&data, 1, "is_own_verdict"), 1);
        let stability = &data["stability"];
        assert_eq!(stability["verdicts"][1]["failed"][0]["title"], "row 2 <b>");
        let href = stability["href"].as_str().expect("the page is there");
        assert!(
            href.starts_with("../") && href.ends_with("/index.html"),
            "{href}"
        );
        assert!(
            stability["told"]
                .as_str()
                .is_some_and(|t| t.starts_with("2 rows"))
        );
        assert!(
            stability["stale"].is_string(),
            "measured by another program"
        );
    }

    #[test]
    fn without_verdicts_the_page_says_so() {
        let data = page_with(None);
        assert_eq!(data["stability"], Value::Null);
        assert_eq!(value(&data, 1, "verdict"), Value::Null);
    }

    #[test]
    fn folders_and_files_are_read_and_others_refused() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let file = dir.path().join("results.json");
        fs::write(&file, serde_json::to_vec(&results()).expect("plain")).expect("writable");
        for path in [dir.path(), &file] {
            let source = StabilitySource::read(path).expect("as written");
            let fails = source.verdicts_of("quick", NASTY).map(|v| v.words(1));
            assert_eq!(fails.as_deref(), Some("fails 1 of 2 rows: row 2 <b>"));
            assert_eq!(source.verdicts_of("none", NASTY), None);
            let preset = format!("quick, {NASTY}");
            assert_eq!(source.place_of("mine", &preset), Some((1, true)));
        }
        let missing = StabilitySource::read(&dir.path().join("none"));
        assert!(missing.is_err());
    }

    fn source(program: &str, commit: &str) -> StabilitySource {
        StabilitySource {
            folder: PathBuf::new(),
            verdicts: Vec::new(),
            description: String::new(),
            program: program.to_owned(),
            commit: Some(commit.to_owned()),
        }
    }

    #[test]
    fn verdicts_of_other_code_are_reported() {
        let scene = Stored {
            plan: plan(),
            place: 0,
            program: "p".to_owned(),
            environment: Environment {
                commit: Some("c".to_owned()),
                ..Environment::default()
            },
            notices: Vec::new(),
            result: Default::default(),
        };
        let scenes = [scene];
        assert_eq!(source("p", "c").stale(&scenes), None);
        let build = source("q", "c").stale(&scenes).expect("told");
        assert!(build.contains("another build of commit c"), "{build}");
        let commit = source("q", "d").stale(&scenes).expect("told");
        assert!(
            commit.contains("commit d") && commit.contains("commit c"),
            "{commit}"
        );
    }

    #[test]
    fn addresses_lead_from_one_folder_to_another() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let [a, b] = ["target/compare", "target/stability"].map(|name| dir.path().join(name));
        for folder in [&a, &b] {
            std::fs::create_dir_all(folder).expect("writable");
        }
        assert_eq!(relative(&a, &b).as_deref(), Some("../stability"));
        assert_eq!(
            relative(dir.path(), &b).as_deref(),
            Some("target/stability")
        );
        assert_eq!(relative(&a, &a).as_deref(), Some("."));
        assert_eq!(relative(&a, &dir.path().join("none")), None);
    }
}
