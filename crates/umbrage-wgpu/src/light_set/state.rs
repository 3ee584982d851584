//! The state of a light in a set, and its maps.

use crate::{
    cast::bind_peeled,
    filter::FilterStage,
    light_set::{
        culling::Volume,
        options::{SetLight, Unserved},
        plan::{Difference, LightPlan},
        pool::LayerRange,
    },
    resources::{
        bindings::Binding, counters::ResourceFactory, images::GpuImage, pipelines::Pipelines,
    },
    targets::CastTarget,
};
use umbrage_core::{Aabb, RecipeError};
use wgpu::Texture;

/// The state of a light. A light that is not [`Shown`](Self::Shown) is lit everywhere.
#[derive(Debug, Default)]
pub(crate) enum LightState {
    /// It was added since the last frame.
    #[default]
    New,
    /// Its technique can't serve it.
    Refused(RecipeError),
    /// It has a plan and no layers: lights of a higher priority have them.
    OverBudget(LightPlan),
    /// It has layers, which do not show its plan yet.
    Waiting(LightPlan),
    /// Its layers and its numbers in shaders are those of a plan.
    Shown {
        plan: LightPlan,
        /// The plan that replaces it.
        next: Option<Box<LightPlan>>,
    },
}

impl LightState {
    /// Returns the newest plan.
    pub(crate) fn newest(&self) -> Option<&LightPlan> {
        match self {
            Self::New | Self::Refused(_) => None,
            Self::OverBudget(plan) | Self::Waiting(plan) => Some(plan),
            Self::Shown { plan, next } => Some(next.as_deref().unwrap_or(plan)),
        }
    }

    /// Returns the plan that shaders see.
    pub(crate) fn shown(&self) -> Option<&LightPlan> {
        match self {
            Self::Shown { plan, .. } => Some(plan),
            _ => None,
        }
    }

    /// Returns whether the light has layers that don't show its newest plan.
    pub(crate) fn has_next(&self) -> bool {
        matches!(self, Self::Waiting(_) | Self::Shown { next: Some(_), .. })
    }

    /// Returns why the light is lit everywhere, if it is.
    pub(crate) fn unserved(&self) -> Option<Unserved> {
        match self {
            Self::Refused(error) => Some(Unserved::Refused(error.clone())),
            Self::OverBudget(_) => Some(Unserved::OverBudget),
            Self::New | Self::Waiting(_) => Some(Unserved::Waiting),
            Self::Shown { .. } => None,
        }
    }

    /// Takes a new plan, and returns its difference from the newest one before.
    pub(crate) fn take_plan(&mut self, new: LightPlan) -> Difference {
        let difference = self
            .newest()
            .map_or(Difference::Images, |before| new.difference(before));
        match self {
            Self::New | Self::Refused(_) | Self::OverBudget(_) => *self = Self::OverBudget(new),
            Self::Waiting(plan) => *plan = new,
            Self::Shown { plan, next } => {
                let is_other = new.difference(plan) != Difference::Nothing;
                *next = is_other.then(|| Box::new(new));
            }
        }
        difference
    }

    /// Shows the newest plan. Returns its difference from the one that was shown, if there is a new
    /// one.
    pub(crate) fn show_next(&mut self) -> Option<Difference> {
        let (plan, difference) = match std::mem::take(self) {
            Self::Waiting(plan) => (plan, Difference::Images),
            Self::Shown {
                plan,
                next: Some(next),
            } => {
                let difference = next.difference(&plan);
                (*next, difference)
            }
            unchanged => {
                *self = unchanged;
                return None;
            }
        };
        *self = Self::Shown { plan, next: None };
        Some(difference)
    }

    /// The light gets layers.
    pub(crate) fn gain_layers(&mut self) {
        *self = match std::mem::take(self) {
            Self::OverBudget(plan) => Self::Waiting(plan),
            other => other,
        };
    }

    /// The content of the light's layers is lost.
    pub(crate) fn lose_content(&mut self) {
        *self = match std::mem::take(self) {
            Self::Shown { plan, next } => Self::Waiting(next.map_or(plan, |next| *next)),
            other => other,
        };
    }

    /// The light's layers are taken away.
    pub(crate) fn lose_layers(&mut self) {
        self.lose_content();
        *self = match std::mem::take(self) {
            Self::Waiting(plan) => Self::OverBudget(plan),
            other => other,
        };
    }
}

/// A light of the set.
#[derive(Debug)]
pub(crate) struct HeldLight {
    /// Its index in shaders.
    pub(crate) index: u32,
    pub(crate) settings: SetLight,
    /// Whether the settings changed since the last plan.
    pub(crate) has_changed: bool,
    pub(crate) state: LightState,
    pub(crate) maps: LightMaps,
    /// Frames for which its redraw waited.
    pub(crate) age: u32,
}

/// Layers of a light, and the stages that draw them.
#[derive(Debug, Default)]
pub(crate) struct LightMaps {
    /// For each image of the plan, its layers in the pool.
    pub(crate) ranges: Vec<LayerRange>,
    pub(crate) images: Vec<GpuImage>,
    pub(crate) casts: Vec<LightCast>,
    pub(crate) filters: FilterStage,
}

/// One cast of a light that is shown.
#[derive(Debug)]
pub(crate) struct LightCast {
    pub(crate) target: CastTarget,
    /// Layer of the light's images that it draws into. Casts with the same number are drawn
    /// together.
    pub(crate) layer: u32,
    /// Layer of the pool's texture that holds the light's.
    pub(crate) texture_layer: u32,
    pub(crate) volume: Volume,
    /// The layer that it peels off.
    pub(crate) peeled: Binding,
    /// Whether something changed in it since it was drawn.
    pub(crate) is_stale: bool,
    /// Whether its layer holds anything of the plan that is shown. If not, no budget puts its draw
    /// off: shaders read it.
    pub(crate) is_drawn: bool,
    /// A layer of the casters that are still, onto a copy of which those that move are drawn: see
    /// `still_layers.rs`.
    pub(crate) still: Option<StillLayer>,
}

/// A layer that holds the casters that are still.
#[derive(Debug)]
pub(crate) struct StillLayer {
    pub(crate) texture: Texture,
    pub(crate) target: CastTarget,
    /// Whether the casters that are still changed in it since it was drawn.
    pub(crate) is_stale: bool,
}

impl HeldLight {
    pub(crate) fn new(index: u32, settings: SetLight) -> Self {
        Self {
            index,
            settings,
            has_changed: true,
            state: LightState::New,
            maps: LightMaps::default(),
            age: 0,
        }
    }

    /// Returns the order of redraws: greater numbers come first.
    pub(crate) fn urgency(&self) -> f32 {
        self.settings.priority * (1 + self.age) as f32
    }

    /// Returns whether shaders read a layer that was never drawn: its frame was prepared and then
    /// not recorded, or not submitted.
    pub(crate) fn is_undrawn(&self) -> bool {
        self.state.shown().is_some() && self.maps.casts.iter().any(|cast| !cast.is_drawn)
    }

    /// Returns how many layers wait to be drawn: all of a plan that is not shown, else those in
    /// which something changed.
    pub(crate) fn waiting_layers(&self) -> u32 {
        let all = |plan: &LightPlan| plan.recipe.casts.len() as u32;
        match &self.state {
            LightState::Waiting(plan) => all(plan),
            LightState::Shown {
                plan,
                next: Some(next),
            } if next.difference(plan) > Difference::Numbers => all(next),
            _ => self.maps.casts.iter().filter(|cast| cast.is_stale).count() as u32,
        }
    }
}

impl LightMaps {
    /// Marks the casts in which one of these boxes may show; `still_changed` are those of casters
    /// that are still.
    pub(crate) fn mark_stale(&mut self, changed: &[Aabb], still_changed: &[Aabb]) {
        for cast in &mut self.casts {
            let volume = cast.volume;
            if let Some(still) = &mut cast.still {
                still.is_stale |= still_changed.iter().any(|b| volume.may_show(b));
            }
        }
        for i in 0..self.casts.len() {
            let cast = &self.casts[i];
            if !cast.is_stale && changed.iter().any(|b| cast.volume.may_show(b)) {
                let layer = cast.layer;
                // A layer is drawn as a whole: later casts into it may read what earlier ones drew.
                for other in &mut self.casts {
                    other.is_stale |= other.layer == layer;
                }
            }
        }
    }

    /// Marks all casts, as if nothing had been drawn.
    pub(crate) fn mark_all_stale(&mut self) {
        for cast in &mut self.casts {
            cast.is_stale = true;
            cast.is_drawn = false;
            if let Some(still) = &mut cast.still {
                still.is_stale = true;
            }
        }
    }

    /// Returns whether the layers may be split by what moves: each is drawn by one cast, which
    /// reads no other.
    pub(crate) fn may_split(&self) -> bool {
        let casts = &self.casts;
        casts.iter().enumerate().all(|(i, cast)| {
            let is_only = casts[..i].iter().all(|other| other.layer != cast.layer);
            cast.target.behind.is_none() && is_only
        })
    }

    /// Makes the casts of a plan, all to be drawn.
    pub(crate) fn make_casts(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        plan: &LightPlan,
    ) {
        let casts = &plan.recipe.casts;
        let mut held = std::mem::take(&mut self.casts).into_iter();
        for (i, cast) in casts.iter().enumerate() {
            let target = CastTarget::new(casts, i, &self.images);
            let (mut peeled, still) = match held.next() {
                Some(held) => (held.peeled, held.still),
                None => (Binding::default(), None),
            };
            bind_peeled(&mut peeled, factory, pipelines, &target);
            // Casts are kept only as long as the light's layers are, so the still layer fits and is
            // drawn again.
            let still = still.map(|still| StillLayer {
                target: target.with_layer(still.target.layer),
                is_stale: true,
                ..still
            });
            self.casts.push(LightCast {
                layer: cast.layer,
                texture_layer: self.ranges[cast.image].layers.start + cast.layer,
                volume: Volume::new(&target.clip_from_world, target.size.min_element()),
                target,
                peeled,
                is_stale: true,
                is_drawn: false,
                still,
            });
        }
    }
}
