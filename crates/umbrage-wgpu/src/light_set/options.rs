//! Options of a set, its lights and frames, and its reports.

use crate::device::later_errors::ApiErrors;
use slotmap::new_key_type;
use std::sync::Arc;
use umbrage_core::{Aabb, Camera, Geometry, Light, RecipeError, ShadowTechnique, View};

/// What a set may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetBudget {
    /// Most bytes of all lights' layers together. Lights that don't fit, those of the least
    /// priority, are not served.
    pub bytes: u64,
    /// Most layers drawn in a frame, but always those of one light. The others keep what was drawn
    /// before, or wait: see [`Unserved::Waiting`](crate::Unserved::Waiting).
    pub redraws: u32,
}

impl Default for SetBudget {
    /// 256 MiB, and no bound on redraws.
    fn default() -> Self {
        Self {
            bytes: 256 << 20,
            redraws: u32::MAX,
        }
    }
}

/// Whether a layer in which something moves keeps what is still in a layer of its own, which is
/// copied instead of drawn again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StillLayers {
    /// Where drawing what is still would take longer than the copy.
    #[default]
    Auto,
    /// Wherever something moves.
    Always,
    /// Nowhere.
    Never,
}

/// Options that hold for all that a set does.
#[derive(Clone, Debug, Default)]
pub struct LightSetOptions {
    /// Index of the bind group that [`LightSet::wgsl`](crate::LightSet::wgsl) declares: the only
    /// one that the set takes.
    pub group: u32,
    /// Stands before every name that [`LightSet::wgsl`](crate::LightSet::wgsl) declares.
    pub prefix: String,
    /// What the set may take.
    pub budget: SetBudget,
    /// Whether layers are split by what moves.
    pub still_layers: StillLayers,
    /// When errors of the graphics API are reported.
    pub errors: ApiErrors,
}

/// What a frame is planned for.
#[derive(Clone, Copy, Debug)]
pub struct SetFrame<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The casters' triangles, where the program has them: techniques that trace rays need them.
    /// Without them, techniques that read lists of casters have the device list them
    /// ([`ShadowTechnique::device_recipe`](umbrage_core::ShadowTechnique::device_recipe)), from
    /// buffers that have usage `STORAGE`, too.
    pub geometry: Option<FrameGeometry<'a>>,
}

impl<'a> SetFrame<'a> {
    /// Returns what a light's plan is made for.
    pub(crate) fn view_of(&self, light: &'a Light, casters: Aabb) -> View<'a> {
        View {
            camera: self.camera,
            light,
            casters,
            geometry: self.geometry.map(|g| g.triangles),
            receivers: None,
            fits: None,
        }
    }
}

/// A geometry that may change between frames.
#[derive(Clone, Copy, Debug)]
pub struct FrameGeometry<'a> {
    /// The triangles.
    pub triangles: &'a Geometry,
    /// Another number whenever the triangles changed.
    pub revision: u64,
}

new_key_type! {
    /// Names a light of a [`LightSet`](crate::LightSet).
    pub struct LightId;
}

/// A light and how its shadows are made.
#[derive(Clone, Debug)]
pub struct SetLight {
    /// The light.
    pub light: Light,
    /// The technique, with its settings. Techniques that draw from the camera (planar, volumes) are
    /// refused.
    pub technique: Arc<dyn ShadowTechnique>,
    /// 0 or more. Where not all lights can be served, or redrawn in one frame, those with greater
    /// numbers come first. Light that arrives times pixels that it lights is a good measure.
    pub priority: f32,
}

/// Why a light casts no shadows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unserved {
    /// Its technique can't serve it here.
    #[error(transparent)]
    Refused(RecipeError),
    /// Lights of a higher priority take the bytes of [`SetBudget::bytes`](crate::SetBudget::bytes),
    /// or all layers that the device allows in a texture.
    #[error("lights of a higher priority take the bytes of the budget, or all layers of a texture")]
    OverBudget,
    /// Its maps are drawn in one of the next frames: see
    /// [`SetBudget::redraws`](crate::SetBudget::redraws).
    #[error("its maps are drawn in one of the next frames, as the budget of redraws says")]
    Waiting,
}

/// What [`LightSet::prepare`](crate::LightSet::prepare) found to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetReport {
    /// Lights that were planned.
    pub planned: u32,
    /// Layers that this frame draws.
    pub redrawn: u32,
    /// Lights whose lists of casters this frame makes.
    pub listed: u32,
    /// Layers that wait for one of the next frames, as
    /// [`SetBudget::redraws`](crate::SetBudget::redraws) demands.
    pub waiting: u32,
    /// Bytes written to the GPU.
    pub uploaded: u64,
}
