//! Merges the reports of a comparison's shards into one. The result is equal byte by byte to that
//! of a single run with the same figures.

use super::{
    assemble,
    run::Run,
    stability_source::StabilitySource,
    store::{ComparisonPlan, Stored},
};
use crate::{compare::Comparison, error::LabError, output::folder::Folder};
use std::{
    fs, io,
    path::{Path, PathBuf},
};
use umbrage_core::Invalid;

/// Joins the scenes of several folders. Returns the whole comparison and the page's path.
///
/// Only the last run of each folder counts: scenes of earlier runs are ignored. `stability` has the
/// verdicts that the page shows for each setting.
///
/// # Errors
/// Errors if folders contain no scenes, scenes of different comparisons, one scene twice or changed
/// figures, if scenes are missing, or if a file cannot be read or written.
pub fn merge(
    folders: &[PathBuf],
    out: &Path,
    stability: Option<&StabilitySource>,
) -> Result<(Comparison, PathBuf), LabError> {
    // Read the runs and their scenes, and check that they are complete.
    let mut runs = Vec::new();
    for folder in folders {
        runs.push((folder.as_path(), Run::read(folder, "compare --shard")?));
    }
    let plan = one_plan(&runs)?.clone();
    let mut found = Vec::new();
    for (folder, run) in &runs {
        found.extend(run.scenes(folder)?);
    }
    found.sort_by_key(|(_, s)| s.place);
    check(&plan, &found)?;
    // Copy the scenes' folders.
    let folder = Folder::create(out)?;
    for (from, scene) in &found {
        let to = folder.unfinished_folder(scene.name())?;
        for path in list(from)? {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let bytes = fs::read(&path).map_err(|source| LabError::Write {
                path: path.clone(),
                source,
            })?;
            to.write(&name, &bytes)?;
        }
        folder.finish(scene.name())?;
    }
    // Write the run, and the report of all scenes.
    let run = Run {
        places: (0..plan.scenes.len()).collect(),
        plan,
    };
    run.write(&folder)?;
    let scenes: Vec<Stored> = found.into_iter().map(|(_, scene)| scene).collect();
    assemble::write(out, &folder, &scenes, stability)
}

/// Returns the paths in a folder, sorted.
fn list(folder: &Path) -> Result<Vec<PathBuf>, LabError> {
    let mut paths = Vec::new();
    let entries = fs::read_dir(folder).map_err(|source| unreadable_folder(folder, source))?;
    for entry in entries {
        let entry = entry.map_err(|source| unreadable_folder(folder, source))?;
        paths.push(entry.path());
    }
    paths.sort();
    Ok(paths)
}

fn unreadable_folder(folder: &Path, source: io::Error) -> LabError {
    LabError::Write {
        path: folder.to_owned(),
        source,
    }
}

/// Returns the plan that all runs share; errors if they differ.
fn one_plan<'a>(runs: &'a [(&Path, Run)]) -> Result<&'a ComparisonPlan, Invalid> {
    let Some((first, run)) = runs.first() else {
        return Err(Invalid::new(
            "shards",
            "are missing",
            "pass at least one folder",
        ));
    };
    match runs.iter().find(|(_, other)| other.plan != run.plan) {
        None => Ok(&run.plan),
        Some((folder, _)) => {
            let why = format!("belongs to another comparison than `{}`", first.display());
            let help = "pass only shards of one list of scenes with the same options";
            Err(Invalid::new(
                format!("folder `{}`", folder.display()),
                why,
                help,
            ))
        }
    }
}

/// Checks that all scenes of the plan were found once, measured by the same code.
fn check(plan: &ComparisonPlan, found: &[(PathBuf, Stored)]) -> Result<(), Invalid> {
    for (path, scene) in found {
        let (first_path, first) = &found[0];
        let same_code = scene.environment.version == first.environment.version
            && scene.environment.commit == first.environment.commit
            && scene.environment.backends.len() == first.environment.backends.len();
        if !same_code {
            let why = format!(
                "was measured by another version or on other backends than `{}`",
                first_path.display()
            );
            let help = "run all shards with one commit, then merge again";
            return Err(Invalid::new(format!("`{}`", path.display()), why, help));
        }
    }
    if let Some(pair) = found.windows(2).find(|p| p[0].1.place == p[1].1.place) {
        let why = format!("is the same scene as `{}`", pair[0].0.display());
        let help = "pass each shard once, all with the same number of shards";
        return Err(Invalid::new(
            format!("`{}`", pair[1].0.display()),
            why,
            help,
        ));
    }
    let mut missing: Vec<&str> = Vec::new();
    for (place, name) in plan.scenes.iter().enumerate() {
        if !found.iter().any(|(_, scene)| scene.place == place) {
            missing.push(name);
        }
    }
    if missing.is_empty() {
        return Ok(());
    }
    let why = format!(
        "lack {} of {} scenes: {}",
        missing.len(),
        plan.scenes.len(),
        missing.join(", ")
    );
    Err(Invalid::new(
        "shards",
        why,
        "run the missing or stopped shards, then merge again",
    ))
}
