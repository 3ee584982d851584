//! What the baseline has and the new results lack.

use super::Changes;
use crate::compare::{CompareRow, Comparison};
use std::collections::{BTreeMap, BTreeSet};
use umbrage_core::Invalid;

/// Names of what may be missing, or changed so that it can't be compared: scenes, techniques, backends, or single settings
/// as reports spell them (`pcf (3x3, 1024, bias: none)`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Except(BTreeSet<String>);

impl Except {
    /// Excepts these names.
    pub fn new(names: impl IntoIterator<Item = String>) -> Self {
        Self(names.into_iter().collect())
    }

    /// Refuses names that mean nothing in a baseline: a slip of the pen would else go unnoticed.
    ///
    /// # Errors
    /// Errors on the first name that is neither a scene, a technique, a backend nor a setting of the comparison.
    pub fn check(&self, baseline: &Comparison) -> Result<(), Invalid> {
        let known = |name: &&String| {
            let of_row = |row: &CompareRow| names(row).contains(name);
            baseline
                .scenes
                .iter()
                .any(|s| s.name == **name || s.rows.iter().any(of_row))
        };
        match self.0.iter().find(|name| !known(name)) {
            None => Ok(()),
            Some(name) => {
                let help =
                    "name a scene, a technique, a backend, or a setting as `technique (settings)`";
                Err(Invalid::new(
                    "exception",
                    format!("`{name}` is nothing that the baseline has"),
                    help,
                ))
            }
        }
    }

    fn has(&self, name: &str) -> bool {
        self.0.contains(name)
    }
}

/// What a row may be excepted by, the widest first.
fn names(row: &CompareRow) -> [String; 3] {
    [
        row.backend.clone(),
        row.technique.clone(),
        format!("{} ({})", row.technique, row.settings),
    ]
}

/// What is lost, while scenes are gone through.
pub(super) struct Lost<'a> {
    except: &'a Except,
    /// Scenes as wholes: name and what is wrong.
    scenes: Vec<(String, String)>,
    /// By name: how many rows the baseline has in the scenes compared, and how many are missing.
    rows: BTreeMap<String, [usize; 2]>,
    /// Rows that are missing: the scene, the label, and the names.
    missing: Vec<(String, String, [String; 3])>,
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
        self.scenes.push((name.to_owned(), what.to_owned()));
    }

    /// Takes note of a row of the baseline.
    pub(super) fn row(&mut self, scene: &str, row: &CompareRow, missing: bool) {
        for name in names(row) {
            let [all, lost] = self.rows.entry(name).or_default();
            *all += 1;
            *lost += usize::from(missing);
        }
        if missing {
            self.missing
                .push((scene.to_owned(), row.label(), names(row)));
        }
    }

    /// Says what is lost, as widely as is true: a backend, a technique, a setting, a row.
    pub(super) fn report(self, out: &mut Changes) {
        let mut except = BTreeSet::new();
        for (name, what) in &self.scenes {
            let line = format!("scene {name} {what}");
            if self.except.has(name) {
                out.notes.push(format!("excepted: {line}"));
            } else {
                out.lost.push(line);
                except.insert(name.clone());
            }
        }
        let mut reported = BTreeSet::new();
        let mut excepted = 0;
        for (scene, label, names) in &self.missing {
            if self.except.has(scene) || names.iter().any(|name| self.except.has(name)) {
                excepted += 1;
                continue;
            }
            // The widest of its names of which nothing is left.
            let whole = names
                .iter()
                .find(|name| self.rows[*name][0] == self.rows[*name][1]);
            match whole {
                Some(name) if reported.insert(name.clone()) => {
                    out.lost
                        .push(format!("{name} is missing: {} rows", self.rows[name][1]));
                }
                Some(_) => {}
                None => out.lost.push(format!("{scene}: {label} is missing")),
            }
            except.insert(whole.unwrap_or(&names[2]).clone());
        }
        if excepted > 0 {
            out.notes.push(format!(
                "excepted: {excepted} rows of the baseline are missing"
            ));
        }
        out.except = except.into_iter().collect();
    }
}
