//! Fits that were found before.

use crate::{Layout, LightSpaces, RecipeError, light_space::fit::kind::Fit};
use std::sync::Mutex;

/// The light spaces that were found for one view: techniques whose maps lie alike then share the search. Whoever tries many
/// settings on one view hangs it on that view: [`View::with_fits`](crate::View::with_fits).
#[derive(Debug, Default)]
pub struct FitMemory {
    found: Mutex<Vec<(FitKey, Result<LightSpaces, RecipeError>)>>,
}

/// What a fit hangs on beside the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FitKey {
    pub(super) fit: Fit,
    pub(super) layout: Layout,
    pub(super) size: u32,
    pub(super) margin: f32,
}

impl FitMemory {
    /// What was found before, else what `find` finds.
    pub(super) fn recall(
        &self,
        key: FitKey,
        find: impl FnOnce() -> Result<LightSpaces, RecipeError>,
    ) -> Result<LightSpaces, RecipeError> {
        // A thread that panicked while it held the lock has left whole entries behind.
        let lock = || {
            self.found
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
        };
        if let Some((_, known)) = lock().iter().find(|(before, _)| *before == key) {
            return known.clone();
        }
        let new = find();
        lock().push((key, new.clone()));
        new
    }
}
