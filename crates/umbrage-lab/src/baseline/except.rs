//! Parts of the baseline that the new results don't have, and exceptions for them.

use super::changes::Changes;
use crate::compare::{CompareRow, Comparison};
use std::collections::{BTreeMap, BTreeSet};
use umbrage_core::Invalid;

/// Names of parts that may be missing or no longer comparable: scenes, techniques, backends, or
/// settings as spelt in reports (`pcf (3x3, 1024, bias: none)`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Except(BTreeSet<String>);

impl Except {
    /// Creates exceptions from names.
    pub fn new(names: impl IntoIterator<Item = String>) -> Self {
        Self(names.into_iter().collect())
    }

    /// Checks that each name occurs in a baseline. A misspelt one would have no effect otherwise.
    ///
    /// # Errors
    /// Errors on the first name that is neither a scene, a technique, a backend nor a setting of
    /// the comparison.
    pub fn check(&self, baseline: &Comparison) -> Result<(), Invalid> {
        for name in &self.0 {
            if !has_name(baseline, name) {
                return Err(Invalid::new(
                    "exception",
                    format!("`{name}` does not occur in the baseline"),
                    "name a scene, a technique, a backend, or a setting as `technique (settings)`",
                ));
            }
        }
        Ok(())
    }

    fn has(&self, name: &str) -> bool {
        self.0.contains(name)
    }
}

/// Reports whether a comparison has a scene, technique, backend or setting with this name.
fn has_name(comparison: &Comparison, name: &String) -> bool {
    comparison
        .scenes
        .iter()
        .any(|scene| scene.name == *name || scene.rows.iter().any(|row| names(row).contains(name)))
}

/// Returns the names by which a row may be excepted, most general first: backend, technique,
/// setting.
fn names(row: &CompareRow) -> [String; 3] {
    [
        row.backend.clone(),
        row.technique.clone(),
        format!("{} ({})", row.technique, row.settings),
    ]
}

/// Collects missing parts, scene by scene.
pub(super) struct Lost<'a> {
    except: &'a Except,
    /// Scenes that are missing as a whole.
    scenes: Vec<LostScene>,
    /// Number of the baseline's rows in the compared scenes, for each of their names.
    rows: BTreeMap<String, RowCount>,
    /// Rows that are missing.
    missing: Vec<LostRow>,
}

struct LostScene {
    name: String,
    /// The reason.
    what: String,
}

struct LostRow {
    scene: String,
    label: String,
    /// [`names`].
    names: [String; 3],
}

/// Counts of rows that share a name.
#[derive(Default)]
struct RowCount {
    all: usize,
    /// Number of missing rows.
    lost: usize,
}

impl<'a> Lost<'a> {
    pub(super) fn new(except: &'a Except) -> Self {
        Self {
            except,
            scenes: Vec::new(),
            rows: BTreeMap::new(),
            missing: Vec::new(),
        }
    }

    pub(super) fn scene(&mut self, name: &str, what: &str) {
        self.scenes.push(LostScene {
            name: name.to_owned(),
            what: what.to_owned(),
        });
    }

    /// Adds a row of the baseline.
    pub(super) fn row(&mut self, scene: &str, row: &CompareRow, missing: bool) {
        for name in names(row) {
            let count = self.rows.entry(name).or_default();
            count.all += 1;
            count.lost += usize::from(missing);
        }
        if missing {
            self.missing.push(LostRow {
                scene: scene.to_owned(),
                label: row.label(),
                names: names(row),
            });
        }
    }

    /// Reports missing parts by the most general name that applies: a backend, a technique, a
    /// setting or a row.
    pub(super) fn report(self, out: &mut Changes) {
        let mut except = BTreeSet::new();
        for scene in &self.scenes {
            let line = format!("scene {} {}", scene.name, scene.what);
            if self.except.has(&scene.name) {
                out.notes.push(format!("excepted: {line}"));
            } else {
                out.lost.push(line);
                except.insert(scene.name.clone());
            }
        }
        let mut reported = BTreeSet::new();
        let mut excepted = 0;
        for row in &self.missing {
            let scene = &row.scene;
            if self.except.has(scene) || row.names.iter().any(|name| self.except.has(name)) {
                excepted += 1;
                continue;
            }
            // Find the most general name of the row whose rows are all missing.
            let whole = row.names.iter().find(|name| {
                let count = &self.rows[*name];
                count.all == count.lost
            });
            match whole {
                Some(name) if reported.insert(name.clone()) => {
                    let lost = self.rows[name].lost;
                    out.lost.push(format!("{name} is missing: {lost} rows"));
                }
                Some(_) => {}
                None => {
                    let label = &row.label;
                    out.lost.push(format!("{scene}: {label} is missing"));
                }
            }
            except.insert(whole.unwrap_or(&row.names[2]).clone());
        }
        if excepted > 0 {
            out.notes.push(format!(
                "excepted: {excepted} rows of the baseline are missing"
            ));
        }
        out.except = except.into_iter().collect();
    }
}
