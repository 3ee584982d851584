//! Wrong usage that only a command can detect, such as an unknown scene, and exit codes.

use crate::error::LabError;
use umbrage_core::{BackendError, Invalid, RecipeError};
use umbrage_plan::MeasureError;
use umbrage_scenes::SceneError;

/// An argument names something that doesn't exist. The program exits with 2.
#[derive(Debug)]
pub(crate) struct Usage(pub(crate) String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Returns the exit code for an error.
///
/// 2 means invalid input of the user: names, numbers, and the content of files. 1 means any other
/// failure: invalid results, bounds that nothing meets, a failing device or disk.
pub(crate) fn exit_code(error: &anyhow::Error) -> u8 {
    let is_input = error.is::<Usage>()
        || error.is::<SceneError>()
        || error.is::<Invalid>()
        || matches!(error.downcast_ref(), Some(BackendError::Invalid(_)))
        || matches!(error.downcast_ref(), Some(RecipeError::Invalid(_)))
        || matches!(error.downcast_ref(), Some(MeasureError::Invalid(_)))
        || matches!(
            error.downcast_ref(),
            Some(LabError::Invalid(_) | LabError::Plan(RecipeError::Invalid(_)))
        );
    if is_input { 2 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_kind_of_mistake_has_one_exit_code() {
        let invalid = || Invalid::new("light 3", "is not there", "use 1 or 2");
        let mistakes: [anyhow::Error; 7] = [
            Usage("there is no scene".to_owned()).into(),
            umbrage_scenes::load("nofile.toml")
                .expect_err("no such file")
                .into(),
            invalid().into(),
            BackendError::Invalid(invalid()).into(),
            MeasureError::Invalid(invalid()).into(),
            LabError::Invalid(invalid()).into(),
            LabError::Plan(RecipeError::Invalid(invalid())).into(),
        ];
        for mistake in mistakes {
            assert_eq!(exit_code(&mistake), 2, "{mistake}");
        }
        let failures: [anyhow::Error; 3] = [
            anyhow::anyhow!("2 results are invalid"),
            BackendError::DeviceLost("gone".to_owned()).into(),
            LabError::Backend(BackendError::DeviceLost("gone".to_owned())).into(),
        ];
        for failure in failures {
            assert_eq!(exit_code(&failure), 1, "{failure}");
        }
    }
}
