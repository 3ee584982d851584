//! Cache of the fits of one view.

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

/// Cache of the light spaces of one view. Techniques with the same fit, layout, size and margin
/// share the search. Use one cache when evaluating many settings for the same view, see
/// [`View::with_fits`](crate::View::with_fits).
#[derive(Debug, Default)]
pub struct FitMemory {
    found: Mutex<Vec<FoundFit>>,
    /// The tree over the points of the view's receivers.
    seen: OnceLock<Arc<BoxTree>>,
    /// The cone from the light that contains all casters.
    caster_cone: OnceLock<Cone>,
}

type FoundFit = (FitKey, Result<LightSpaces, RecipeError>);

/// Parameters of light spaces other than the view.
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
    /// Returns the cached result for `key`, or calls `find` and caches its result. Errors are
    /// cached, too.
    pub(super) fn recall(
        &self,
        key: FitKey,
        find: impl FnOnce() -> Result<LightSpaces, RecipeError>,
    ) -> Result<LightSpaces, RecipeError> {
        if let Some((_, known)) = self.lock().iter().find(|(before, _)| *before == key) {
            return known.clone();
        }
        // The lock is free meanwhile: two threads may compute the same result, which only costs
        // time.
        let new = find();
        self.lock().push((key, new.clone()));
        new
    }

    /// Returns the points of the view's receivers, with boxes that are built once.
    pub(super) fn seen_points<'a>(&self, receivers: &'a Receivers) -> SeenPoints<'a> {
        let tree = self
            .seen
            .get_or_init(|| Arc::clone(SeenPoints::new(receivers).tree()));
        SeenPoints::with_tree(receivers, Arc::clone(tree))
    }

    /// Returns the cache of the cone from the light that contains all casters.
    pub(super) fn caster_cone(&self) -> &OnceLock<Cone> {
        &self.caster_cone
    }

    /// Returns whether the view's receivers were already validated.
    pub(crate) fn knows_receivers(&self) -> bool {
        self.seen.get().is_some()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<FoundFit>> {
        // Entries are pushed whole, so a panic in another thread leaves no partial entry.
        self.found.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
