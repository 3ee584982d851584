//! The state of a light in a set, and its maps.

use crate::{
    cast::bind_peeled,
    filter::FilterStage,
    light_set::{
        culling::Volume,
        options::{ShadowedLight, Unserved},
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

/// State of a light. A light that is not [`Shown`](Self::Shown) is lit everywhere.
#[derive(Debug, Default)]
pub(crate) enum LightState {
    /// Added since the last frame.
    #[default]
    New,
    /// Not supported by its technique.
    Refused(RecipeError),
    /// Has a plan, but no layers: lights of a higher priority use them.
    OverBudget(LightPlan),
    /// Has layers that don't show its plan yet.
    Waiting(LightPlan),
    /// Has layers and uniforms of a plan.
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

    /// Returns the plan used by shaders.
    pub(crate) fn shown_plan(&self) -> Option<&LightPlan> {
        match self {
            Self::Shown { plan, .. } => Some(plan),
            _ => None,
        }
    }

    /// Returns the plan used by shaders, or the one that they will use once it is drawn.
    pub(crate) fn plan_with_layers(&self) -> Option<&LightPlan> {
        match self {
            Self::Waiting(plan) | Self::Shown { plan, .. } => Some(plan),
            _ => None,
        }
    }

    /// Returns whether the light has layers that don't show its newest plan.
    pub(crate) fn has_next(&self) -> bool {
        matches!(self, Self::Waiting(_) | Self::Shown { next: Some(_), .. })
    }

    /// Returns whether its newest plan has another kind of kernel than the shown one.
    pub(crate) fn changes_kind(&self) -> bool {
        match self {
            Self::Shown {
                plan,
                next: Some(next),
            } => plan.kind != next.kind,
            _ => false,
        }
    }

    /// Returns the reason why the light is lit everywhere, if it is.
    pub(crate) fn unserved_reason(&self) -> Option<Unserved> {
        match self {
            Self::Refused(error) => Some(Unserved::Refused(error.clone())),
            Self::OverBudget(_) => Some(Unserved::OverBudget),
            Self::New => Some(Unserved::NotPrepared),
            Self::Waiting(_) => Some(Unserved::Waiting),
            Self::Shown { .. } => None,
        }
    }

    /// Stores a new plan, and returns its difference from the previous newest one.
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

    /// Makes the newest plan current. If there is a new one, returns its difference from the one
    /// before.
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

    /// Updates the state after layers were assigned.
    pub(crate) fn gain_layers(&mut self) {
        *self = match std::mem::take(self) {
            Self::OverBudget(plan) => Self::Waiting(plan),
            other => other,
        };
    }

    /// Updates the state after the content of the layers was lost.
    pub(crate) fn lose_content(&mut self) {
        *self = match std::mem::take(self) {
            Self::Shown { plan, next } => Self::Waiting(next.map_or(plan, |next| *next)),
            other => other,
        };
    }

    /// Updates the state after the layers were released.
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
    /// Index in shaders.
    pub(crate) index: u32,
    pub(crate) settings: ShadowedLight,
    /// False for lights that are switched off.
    pub(crate) is_enabled: bool,
    /// True if the light, its technique or `nearest_caster` changed since the last plan.
    pub(crate) has_changed: bool,
    /// Lower bound of the distance from the light's position to a caster, metres: see
    /// [`Casters::distance_from`](super::casters::Casters::distance_from).
    pub(crate) nearest_caster: f32,
    pub(crate) state: LightState,
    pub(crate) maps: LightMaps,
    /// Number of frames for which its redraw waited.
    pub(crate) age: u32,
}

/// Layers of a light, and the stages that draw them.
#[derive(Debug, Default)]
pub(crate) struct LightMaps {
    /// Layers in the pool, for each image of the plan.
    pub(crate) ranges: Vec<LayerRange>,
    pub(crate) images: Vec<GpuImage>,
    pub(crate) casts: Vec<LightCast>,
    pub(crate) filters: FilterStage,
}

/// One cast of a shown light.
#[derive(Debug)]
pub(crate) struct LightCast {
    pub(crate) target: CastTarget,
    /// Layer of the light's images that it draws into. Casts with the same number are drawn
    /// together.
    pub(crate) layer: u32,
    /// The corresponding layer of the pool's texture.
    pub(crate) texture_layer: u32,
    pub(crate) volume: Volume,
    /// The layer that it peels.
    pub(crate) peeled: Binding,
    /// True if something changed in it since it was drawn.
    pub(crate) is_stale: bool,
    /// Index, in the list of changed boxes, of the one that made it stale last. It is tested first,
    /// since programs often move the same casters in the same order.
    last_change: usize,
    /// True if its layer contains anything of the shown plan. If not, no budget delays its draw,
    /// because shaders read it.
    pub(crate) is_drawn: bool,
    /// Layer of the still casters; moving ones are drawn on top of a copy of it. See
    /// `still_layers.rs`.
    pub(crate) still: Option<StillLayer>,
}

/// A layer of the still casters.
#[derive(Debug)]
pub(crate) struct StillLayer {
    pub(crate) texture: Texture,
    pub(crate) target: CastTarget,
    /// True if the still casters in it changed since it was drawn.
    pub(crate) is_stale: bool,
}

impl HeldLight {
    pub(crate) fn new(index: u32, settings: ShadowedLight) -> Self {
        Self {
            index,
            settings,
            is_enabled: true,
            has_changed: true,
            nearest_caster: 0.0,
            state: LightState::New,
            maps: LightMaps::default(),
            age: 0,
        }
    }

    /// Returns the urgency of redraws: greater numbers come first.
    pub(crate) fn urgency(&self) -> f32 {
        self.settings.priority * (1 + self.age) as f32
    }

    /// Returns whether shaders read a layer that was never drawn: its frame was prepared, but not
    /// recorded or submitted.
    pub(crate) fn is_undrawn(&self) -> bool {
        self.state.shown_plan().is_some() && self.maps.casts.iter().any(|cast| !cast.is_drawn)
    }

    /// Returns the number of layers to be drawn: all layers of a plan that is not shown, otherwise
    /// those with changes.
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
    /// Marks the casts in which one of these boxes may be visible; `still_changed` are those of
    /// still casters.
    pub(crate) fn mark_stale(&mut self, changed: &[Aabb], still_changed: &[Aabb]) {
        for cast in &mut self.casts {
            let volume = cast.volume;
            if let Some(still) = &mut cast.still {
                still.is_stale |= still_changed.iter().any(|b| volume.may_show(b));
            }
        }
        for i in 0..self.casts.len() {
            let cast = &mut self.casts[i];
            if !cast.is_stale && cast.volume.may_show_any(changed, &mut cast.last_change) {
                let layer = cast.layer;
                // Mark all casts into the layer: later ones may read what earlier ones drew.
                for other in &mut self.casts {
                    other.is_stale |= other.layer == layer;
                }
            }
        }
    }

    /// Marks all casts as never drawn.
    pub(crate) fn mark_all_stale(&mut self) {
        for cast in &mut self.casts {
            cast.is_stale = true;
            cast.is_drawn = false;
            if let Some(still) = &mut cast.still {
                still.is_stale = true;
            }
        }
    }

    /// Returns whether the layers may be split into still and moving casters: each is drawn by one
    /// cast, which reads no other.
    pub(crate) fn may_split(&self) -> bool {
        let casts = &self.casts;
        casts.iter().enumerate().all(|(i, cast)| {
            let is_only = casts[..i].iter().all(|other| other.layer != cast.layer);
            cast.target.behind.is_none() && is_only
        })
    }

    /// Builds the casts of a plan, all to be drawn.
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
            // Keep the still layer and redraw it. It fits, because casts are kept only as long as
            // the light's layers are.
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
                last_change: 0,
                is_drawn: false,
                still,
            });
        }
    }
}
