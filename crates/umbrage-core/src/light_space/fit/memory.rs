//! A memory of the fits of one view.

use crate::{
    gbuffer::{receivers::Receivers, seen_points::SeenPoints},
    geometry::box_tree::BoxTree,
    light_space::{
        fit::kind::Fit,
        layers::{Layout, LightSpaces},
    },
    recipe_error::RecipeError,
};
use glam::Vec3;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// The light spaces that were found for one view, so that techniques with the same fit, layout,
/// size and margin share the search. A program that tries many settings on one view gives it to
/// that view: [`View::with_fits`](crate::View::with_fits).
#[derive(Debug, Default)]
pub struct FitMemory {
    found: Mutex<Vec<FoundFit>>,
    /// The tree over the points of the view's receivers.
    seen: OnceLock<Arc<BoxTree>>,
    /// The cone from the light that holds all casters.
    caster_cone: OnceLock<Cone>,
}

type FoundFit = (FitKey, Result<LightSpaces, RecipeError>);

/// What light spaces depend on beside the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FitKey {
    pub(super) fit: Fit,
    pub(super) layout: Layout,
    pub(super) size: u32,
    pub(super) margin: f32,
}

/// A cone with its apex at the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// World space, unit.
    pub(super) axis: Vec3,
    /// Radians.
    pub(super) half_angle: f32,
}

impl FitMemory {
    /// Returns what was found for `key` before, else what `find` returns, which it remembers.
    /// Errors are remembered, too.
    pub(super) fn recall(
        &self,
        key: FitKey,
        find: impl FnOnce() -> Result<LightSpaces, RecipeError>,
    ) -> Result<LightSpaces, RecipeError> {
        if let Some((_, known)) = self.lock().iter().find(|(before, _)| *before == key) {
            return known.clone();
        }
        // The lock is free meanwhile: two threads may find the same, which costs time alone.
        let new = find();
        self.lock().push((key, new.clone()));
        new
    }

    /// Returns the points of the view's receivers, with boxes that are made once.
    pub(super) fn seen_points<'a>(&self, receivers: &'a Receivers) -> SeenPoints<'a> {
        let tree = self
            .seen
            .get_or_init(|| Arc::clone(SeenPoints::new(receivers).tree()));
        SeenPoints::with_tree(receivers, Arc::clone(tree))
    }

    /// Returns where the cone from the light that holds all casters is kept.
    pub(super) fn caster_cone(&self) -> &OnceLock<Cone> {
        &self.caster_cone
    }

    /// Returns whether the view's receivers are known to be valid.
    pub(crate) fn knows_receivers(&self) -> bool {
        self.seen.get().is_some()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<FoundFit>> {
        // Entries are pushed whole, so a thread that panicked while it held the lock has left no
        // broken one.
        self.found.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
