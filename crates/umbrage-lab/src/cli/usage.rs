//! Wrong usage that only a command itself can see, such as a scene's name, and the exit codes.

use crate::error::LabError;
use umbrage_core::{BackendError, Invalid, RecipeError};
use umbrage_plan::MeasureError;
use umbrage_scenes::SceneError;

/// The user asked for something that isn't there. The program ends with 2.
#[derive(Debug)]
pub(crate) struct Usage(pub(crate) String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Returns the exit code after an error: 2 if what the user gave can't be used (names, numbers, and
/// what is in files), 1 for all else: results that must not be, bounds that nothing keeps, a device
/// or a disk that fails.
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
            anyhow::anyhow!("2 results must not be"),
            BackendError::DeviceLost("gone".to_owned()).into(),
            LabError::Backend(BackendError::DeviceLost("gone".to_owned())).into(),
        ];
        for failure in failures {
            assert_eq!(exit_code(&failure), 1, "{failure}");
        }
    }
}
