//! Options of a set, its lights and frames, and its reports.

use crate::device::later_errors::ApiErrors;
use std::sync::Arc;
use umbrage_core::{Aabb, Camera, Geometry, Light, RecipeError, ShadowTechnique, View};

/// Budget of a light set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetBudget {
    /// Greatest size of all lights' layers together, bytes. Lights that don't fit, those of the
    /// least priority, have no shadows.
    pub bytes: u64,
    /// Greatest number of layers drawn per frame; at least those of one light are drawn. The others
    /// keep their contents, or wait: see [`Unserved::Waiting`](crate::Unserved::Waiting). Lights
    /// with another kind of technique don't wait.
    pub redraws: u32,
}

impl Default for SetBudget {
    /// Returns 256 MiB, and no limit on redraws.
    fn default() -> Self {
        Self {
            bytes: 256 << 20,
            redraws: u32::MAX,
        }
    }
}

/// Use of separate layers for still casters, which are copied instead of redrawn where something
/// moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StillLayers {
    /// Used if drawing the still casters would cost more than the copy.
    #[default]
    Auto,
    /// Used wherever something moves.
    Always,
    /// Never used.
    Never,
}

/// Options of a light set.
#[derive(Clone, Debug, Default)]
pub struct LightSetOptions {
    /// Index of the bind group that [`LightSet::wgsl`](crate::LightSet::wgsl) declares: the only
    /// one that the set uses.
    pub group: u32,
    /// Prefix of every name that [`LightSet::wgsl`](crate::LightSet::wgsl) declares.
    pub prefix: String,
    /// Budget of the set.
    pub budget: SetBudget,
    /// Use of separate layers for still casters.
    pub still_layers: StillLayers,
    /// Time at which errors of the graphics API are reported.
    pub errors: ApiErrors,
}

/// Inputs of a frame.
#[derive(Clone, Copy, Debug)]
pub struct SetFrame<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The casters' triangles, if available on the CPU; ray-tracing techniques need them. Without
    /// them, the device builds a hierarchy of the casters for techniques that can use one
    /// ([`ShadowTechnique::device_recipe`](umbrage_core::ShadowTechnique::device_recipe)). Its
    /// buffers then also need the usage `STORAGE`.
    pub geometry: Option<FrameGeometry<'a>>,
}

impl<'a> SetFrame<'a> {
    /// Returns the view for a light's plan: its casters are in a box, and at least at this distance
    /// from the light's position.
    pub(crate) fn view_of(&self, light: &'a Light, casters: Aabb, nearest_caster: f32) -> View<'a> {
        View {
            camera: self.camera,
            light,
            casters,
            nearest_caster,
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
    /// A number that must change whenever the triangles do.
    pub revision: u64,
}

/// A light with its shadow technique.
#[derive(Clone, Debug)]
pub struct ShadowedLight {
    /// The light.
    pub light: Light,
    /// The technique, with its settings. Some are refused in a set. `planar` and `volumes` draw from
    /// the camera. `traced` and `soft` need the triangles on the CPU ([`SetFrame::geometry`]), as
    /// does `exact` with casters that the program draws itself; otherwise the device builds a
    /// hierarchy from the set's meshes and alpha-tested triangles.
    pub technique: Arc<dyn ShadowTechnique>,
    /// Priority, 0 or more. Lights with greater numbers come first if not all lights can have
    /// shadows, or be redrawn in one frame. A good measure is the light's intensity times the
    /// number of pixels that it lights.
    pub priority: f32,
}

impl ShadowedLight {
    /// Returns a light of priority 1 with a technique.
    pub fn new(light: Light, technique: impl ShadowTechnique + 'static) -> Self {
        Self {
            light,
            technique: Arc::new(technique),
            priority: 1.0,
        }
    }
}

/// The former name of [`ShadowedLight`].
#[deprecated(since = "0.1.0", note = "renamed to `ShadowedLight`")]
pub type SetLight = ShadowedLight;

/// Reason why a light casts no shadows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unserved {
    /// The technique doesn't support this light or scene.
    #[error(transparent)]
    Refused(RecipeError),
    /// Lights of a higher priority use all of [`SetBudget::bytes`](crate::SetBudget::bytes), or all
    /// layers that the device allows in a texture.
    #[error("lights of a higher priority use the whole byte budget, or all layers of a texture")]
    OverBudget,
    /// The maps are drawn in one of the next frames: see
    /// [`SetBudget::redraws`](crate::SetBudget::redraws).
    #[error("its maps wait for one of the next frames, because of the redraw budget")]
    Waiting,
    /// There was no [`LightSet::prepare`](crate::LightSet::prepare) since the light was added, or
    /// the last one failed.
    #[error("the set is not prepared: call `prepare`, and check its error")]
    NotPrepared,
}

/// Statistics of [`LightSet::prepare`](crate::LightSet::prepare).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetReport {
    /// Number of lights that were planned.
    pub planned: u32,
    /// Number of layers that this frame draws, including those that keep still casters.
    pub redrawn: u32,
    /// Number of lights whose hierarchies of casters this frame builds.
    pub hierarchies: u32,
    /// Number of layers that wait for one of the next frames because of
    /// [`SetBudget::redraws`](crate::SetBudget::redraws).
    pub waiting: u32,
    /// Bytes written to the GPU.
    pub uploaded: u64,
}
