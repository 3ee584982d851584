//! One light of a set.

use crate::{
    filter::FilterStage,
    light_set::{
        culling::Volume,
        plan::{Difference, LightPlan},
        pool::LayerRange,
    },
    resources::{
        bindings::{Binding, Bound},
        counters::ResourceFactory,
        images::GpuImage,
    },
    targets::CastTarget,
};
use glam::Mat4;
use slotmap::new_key_type;
use std::sync::Arc;
use umbrage_core::{Aabb, Light, RecipeError, ShadowTechnique};
use wgpu::{BindGroupLayout, Texture};

new_key_type! {
    /// Names a light of a [`LightSet`](crate::LightSet).
    pub struct LightId;
}

/// A light and how its shadows are made.
#[derive(Clone, Debug)]
pub struct SetLight {
    /// The light.
    pub light: Light,
    /// The technique, with its settings. Techniques that draw from the camera (planar, volumes) are refused.
    pub technique: Arc<dyn ShadowTechnique>,
    /// 0 or more. Where not all lights can be served, or redrawn in one frame, those with greater numbers come first. Light that arrives times
    /// pixels that it lights is a good measure.
    pub priority: f32,
}

/// Why a light casts no shadows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unserved {
    /// Its technique can't serve it here.
    #[error(transparent)]
    Refused(RecipeError),
    /// Lights of a higher priority take the bytes of [`SetBudget::bytes`](crate::SetBudget::bytes), or all layers that the device
    /// allows in a texture.
    #[error("lights of a higher priority take the bytes of the budget, or all layers of a texture")]
    OverBudget,
    /// Its maps are drawn in one of the next frames: see [`SetBudget::redraws`](crate::SetBudget::redraws).
    #[error("its maps are drawn in one of the next frames, as the budget of redraws says")]
    Waiting,
}

/// One cast of a light that is shown.
#[derive(Debug)]
pub(crate) struct LightCast {
    pub(crate) target: CastTarget,
    /// Which layer of the light's images it draws into; casts with the same number are drawn together.
    pub(crate) layer: u32,
    /// The layer of the texture that holds the light's.
    pub(crate) texture_layer: u32,
    pub(crate) volume: Volume,
    /// The layer that it peels off.
    pub(crate) peeled: Binding,
    /// Whether something changed in it since it was drawn.
    pub(crate) is_stale: bool,
    /// Whether its layer holds anything of the plan that is shown. If not, no budget may put off that it is drawn: shaders read it.
    pub(crate) is_drawn: bool,
    /// A layer of its own with the casters that are still, to which those that move are added: see `still_layers.rs`.
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

/// A light of the set, and all that is kept for it.
#[derive(Debug)]
pub(crate) struct LightState {
    /// Its index in shaders.
    pub(crate) index: u32,
    pub(crate) settings: SetLight,
    /// Whether the settings changed since the last plan.
    pub(crate) has_changed: bool,
    /// The plan that is to be shown next; none if it is the one that is shown.
    pub(crate) wanted: Option<LightPlan>,
    /// The plan that the layers and the shaders' numbers are of.
    pub(crate) shown: Option<LightPlan>,
    pub(crate) refused: Option<RecipeError>,
    /// Whether the budget has room for it.
    pub(crate) has_room: bool,
    /// For each image of the plan, its layers; empty while the light has no room.
    pub(crate) ranges: Vec<LayerRange>,
    pub(crate) images: Vec<GpuImage>,
    pub(crate) filters: FilterStage,
    pub(crate) casts: Vec<LightCast>,
    /// Index of its kernel's uniforms, by kind.
    pub(crate) record: Option<KernelRecord>,
    /// Frames for which its redraw waited.
    pub(crate) age: u32,
}

/// Where a light's uniforms are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct KernelRecord {
    pub(crate) kind: usize,
    pub(crate) index: usize,
}

impl LightState {
    pub(crate) fn new(index: u32, settings: SetLight) -> Self {
        Self {
            index,
            settings,
            has_changed: true,
            wanted: None,
            shown: None,
            refused: None,
            has_room: false,
            ranges: Vec::new(),
            images: Vec::new(),
            filters: FilterStage::default(),
            casts: Vec::new(),
            record: None,
            age: 0,
        }
    }

    /// Returns the newest plan.
    pub(crate) fn plan(&self) -> Option<&LightPlan> {
        self.wanted.as_ref().or(self.shown.as_ref())
    }

    /// Takes a new plan, and returns what differs from the newest one before.
    pub(crate) fn take_plan(&mut self, plan: LightPlan) -> Difference {
        let difference = self
            .plan()
            .map_or(Difference::Images, |before| plan.difference(before));
        let from_shown = self
            .shown
            .as_ref()
            .map_or(Difference::Images, |shown| plan.difference(shown));
        self.wanted = (from_shown != Difference::Nothing).then_some(plan);
        self.refused = None;
        difference
    }

    /// Returns what decides which redraws come first.
    pub(crate) fn urgency(&self) -> f32 {
        self.settings.priority * (1 + self.age) as f32
    }

    /// Returns why the light is lit everywhere, if it is.
    pub(crate) fn unserved(&self) -> Option<Unserved> {
        if let Some(error) = &self.refused {
            return Some(Unserved::Refused(error.clone()));
        }
        if !self.has_room {
            return Some(Unserved::OverBudget);
        }
        self.shown.is_none().then_some(Unserved::Waiting)
    }

    /// Marks the casts in which one of these boxes may show; `still_changed` are those of casters that are still.
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

    /// Returns whether shaders read a layer that was never drawn: its frame was prepared and then not recorded, or not submitted.
    pub(crate) fn is_undrawn(&self) -> bool {
        self.shown.is_some() && self.casts.iter().any(|cast| !cast.is_drawn)
    }

    /// Returns how many layers wait to be drawn: all of a plan that is not shown, else those in which something changed.
    pub(crate) fn waiting_layers(&self) -> u32 {
        if let Some(wanted) = &self.wanted {
            let is_redrawn = self
                .shown
                .as_ref()
                .is_none_or(|shown| wanted.difference(shown) > Difference::Numbers);
            if is_redrawn {
                return wanted.recipe.casts.len() as u32;
            }
        }
        self.casts.iter().filter(|cast| cast.is_stale).count() as u32
    }

    /// Returns whether its layers may be split by what moves: each is drawn by one cast, which reads no other.
    pub(crate) fn may_split(&self) -> bool {
        let casts = &self.casts;
        casts.iter().enumerate().all(|(i, cast)| {
            let is_only = casts[..i].iter().all(|other| other.layer != cast.layer);
            cast.target.behind.is_none() && is_only
        })
    }

    /// Makes the casts of the plan that is shown, all to be drawn.
    pub(crate) fn make_casts(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        peeled_layout: &BindGroupLayout,
    ) {
        let Some(shown) = &self.shown else {
            self.casts.clear();
            return;
        };
        let casts = &shown.recipe.casts;
        self.casts.truncate(casts.len());
        for (i, cast) in casts.iter().enumerate() {
            let target = CastTarget::new(casts, i, &self.images);
            let clip_from_world: Mat4 = target.clip_from_world;
            let volume = Volume::new(&clip_from_world, target.size.min_element());
            let held = self.casts.get_mut(i);
            let (mut peeled, still) = held.map_or_else(Default::default, |held| {
                (std::mem::take(&mut held.peeled), held.still.take())
            });
            // The same layer serves again, drawn anew: images are as they were, or the casts were forgotten.
            let still = still.map(|still| StillLayer {
                target: target.with_layer(still.target.layer),
                is_stale: true,
                ..still
            });
            if let Some(other) = &target.behind {
                let bound = vec![Bound::View(other.clone())];
                peeled.set(factory, "umbrage peeled layer", peeled_layout, bound);
            }
            let made = LightCast {
                target,
                layer: cast.layer,
                texture_layer: self.ranges[cast.image].layers.start + cast.layer,
                volume,
                peeled,
                is_stale: true,
                is_drawn: false,
                still,
            };
            match self.casts.get_mut(i) {
                Some(held) => *held = made,
                None => self.casts.push(made),
            }
        }
    }
}
