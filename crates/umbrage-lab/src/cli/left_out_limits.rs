//! Limits of the pixels that truth may leave out as ambiguous.

use crate::compare::Comparison;
use anyhow::{Result, bail};

/// Returns the greatest share of pixels that a scene may leave out as ambiguous: `most`, or its own
/// limit if it is built in and has a greater one. `of_files` are the names of scenes from files.
pub(crate) fn limit_of(name: &str, of_files: &[&str], most: f64) -> f64 {
    let built_in = umbrage_scenes::find(name).filter(|_| !of_files.contains(&name));
    let own = built_in.and_then(|entry| entry.max_left_out);
    own.map_or(most, |own| own.max(most))
}

/// Errors if a scene leaves out more pixels as ambiguous than the limit of its name.
pub(crate) fn check_left_out(comparison: &Comparison, limit: impl Fn(&str) -> f64) -> Result<()> {
    let scenes = comparison.scenes.iter();
    let over: Vec<String> = scenes
        .filter(|scene| scene.truth.share_left_out() > limit(&scene.name))
        .filter_map(|scene| Some(format!("{}: {}", scene.name, scene.truth.left_out_words()?)))
        .collect();
    if over.is_empty() {
        return Ok(());
    }
    bail!(
        "errors don't count enough pixels; bring the light and the camera nearer, or allow more \
         with --max-left-out:\n  {}",
        over.join("\n  ")
    );
}

#[cfg(test)]
mod tests {
    use super::{check_left_out, limit_of};
    use crate::compare::{Comparison, SceneResult, TruthSummary};

    #[test]
    fn scenes_that_leave_out_too_much_are_listed() {
        let scene = |name: &str, ambiguous| SceneResult {
            name: name.to_owned(),
            truth: TruthSummary {
                counted: 100 - ambiguous,
                ambiguous,
                shadowed: 40,
                shadowed_ambiguous: ambiguous.min(40),
                ..TruthSummary::default()
            },
            ..SceneResult::default()
        };
        let comparison = Comparison {
            scenes: vec![scene("a", 5), scene("b", 6), scene("c", 50), scene("d", 90)],
            ..Comparison::default()
        };
        // The last scene has a limit of its own.
        let limit = |name: &str| if name == "d" { 0.95 } else { 0.05 };
        let message = check_left_out(&comparison, limit)
            .expect_err("two")
            .to_string();
        let lines: Vec<&str> = message.lines().skip(1).map(str::trim).collect();
        assert_eq!(
            lines,
            [
                "b: left out as ambiguous: 6 pixels, 6.0 % of those facing the light, among them 15.0 % of the shadow",
                "c: left out as ambiguous: 50 pixels, 50.0 % of those facing the light, all of the shadow among them",
            ]
        );
        assert!(check_left_out(&comparison, |_| 0.9).is_ok());
    }

    #[test]
    fn built_in_scenes_may_have_limits_of_their_own() {
        assert_eq!(limit_of("foliage", &[], 0.05), 0.35);
        assert_eq!(limit_of("foliage", &[], 0.5), 0.5);
        assert_eq!(limit_of("cubes", &[], 0.05), 0.05);
        // A file with the name of a built-in scene has the limit of files.
        assert_eq!(limit_of("foliage", &["foliage"], 0.05), 0.05);
    }
}
