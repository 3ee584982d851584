//! Reads the results of an earlier run.

use crate::compare::{Comparison, SCHEMA};
use serde::Deserialize;
use std::path::Path;
use umbrage_core::Invalid;

/// The oldest readable schema. Later fields may be missing in it.
const OLDEST: u32 = 3;

/// File with the figures of a report.
const RESULTS: &str = "results.json";

/// The schema only: results of other versions have other fields.
#[derive(Deserialize)]
struct Version {
    schema: u32,
}

/// Reads a `results.json`.
///
/// # Errors
/// Errors if it can't be read, isn't a file of results, or has an unsupported schema.
pub fn read(path: &Path) -> Result<Comparison, Invalid> {
    let what = format!("baseline `{}`", path.display());
    let help = "use the results.json that `cargo xtask compare` wrote";
    let refuse = |why: String| Invalid::new(what.clone(), why, help);
    let text = std::fs::read(path).map_err(|e| refuse(format!("cannot be read: {e}")))?;
    let version: Version =
        serde_json::from_slice(&text).map_err(|e| refuse(format!("has no results: {e}")))?;
    if !(OLDEST..=SCHEMA).contains(&version.schema) {
        let why = format!("has schema {}, this program's is {SCHEMA}", version.schema);
        return Err(Invalid::new(
            what,
            why,
            "make a new baseline with this version",
        ));
    }
    serde_json::from_slice(&text).map_err(|e| refuse(format!("is damaged: {e}")))
}

/// Checks that a baseline is not the `results.json` of the new report.
///
/// It would be overwritten, and figures reused from that folder would be compared with themselves.
/// Other files in the folder are kept.
///
/// # Errors
/// Errors if it is that file.
pub fn check_not_overwritten(baseline: &Path, report: &Path) -> Result<(), Invalid> {
    // Compare canonical paths, to resolve links. A missing file has none and can't be overwritten.
    let results = report.join(RESULTS);
    let (Ok(baseline_file), Ok(results_file)) = (baseline.canonicalize(), results.canonicalize())
    else {
        return Ok(());
    };
    if baseline_file != results_file {
        return Ok(());
    }
    Err(Invalid::new(
        format!("baseline `{}`", baseline.display()),
        "is a file of the new report, and would be overwritten",
        "copy it elsewhere, or use another folder with --out",
    ))
}

#[cfg(test)]
mod tests {
    use super::check_not_overwritten;
    use std::fs;

    #[test]
    fn a_baseline_may_not_lie_where_the_report_goes() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let report = dir.path().join("report");
        let elsewhere = dir.path().join("results.json");
        fs::create_dir(&report).expect("writable");
        fs::create_dir(dir.path().join("empty")).expect("writable");
        for file in [&report.join("results.json"), &elsewhere] {
            fs::write(file, b"{}").expect("writable");
        }
        assert!(check_not_overwritten(&elsewhere, &report).is_ok());
        assert!(check_not_overwritten(&elsewhere, &dir.path().join("not yet made")).is_ok());
        let refused = |from: &str| {
            check_not_overwritten(&report.join("results.json"), &dir.path().join(from))
                .expect_err("refused")
        };
        assert!(refused("report").to_string().contains("--out"));
        refused("empty/../report");
        // A copy with another name is kept anywhere. A link counts as its target.
        let kept = report.join("before.json");
        fs::write(&kept, b"{}").expect("writable");
        assert!(check_not_overwritten(&kept, &report).is_ok());
        #[cfg(unix)]
        {
            let link = dir.path().join("link.json");
            std::os::unix::fs::symlink(report.join("results.json"), &link).expect("writable");
            assert!(check_not_overwritten(&link, &report).is_err());
        }
    }
}
