//! Options of a set, and what a frame is prepared for.

use crate::device::later_errors::ApiErrors;
use umbrage_core::{Camera, Geometry};

/// What a set may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetBudget {
    /// Most bytes of all lights' layers together. Lights that don't fit, those of the least priority, are not served.
    pub bytes: u64,
    /// Most layers drawn in a frame, but always those of one light. The others keep what was drawn before, or wait: see
    /// [`Unserved::Waiting`](crate::Unserved::Waiting).
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

/// Whether a layer in which something moves keeps what is still in a layer of its own, which is copied instead of drawn again.
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
    /// Index of the bind group that [`LightSet::wgsl`](crate::LightSet::wgsl) declares: the only one that the set takes.
    pub group: u32,
    /// Stands before every name that [`LightSet::wgsl`](crate::LightSet::wgsl) declares.
    pub prefix: String,
    /// What the set may take.
    pub budget: SetBudget,
    /// Whether layers are split by what moves.
    pub still_layers: StillLayers,
    /// When errors of the graphics API are told.
    pub errors: ApiErrors,
}

/// What a frame is planned for.
#[derive(Clone, Copy, Debug)]
pub struct SetFrame<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The casters' triangles, where the program has them: techniques that trace rays need them. Without them, techniques that ask lists of
    /// casters have the device list them ([`ShadowTechnique::device_recipe`](umbrage_core::ShadowTechnique::device_recipe)), from
    /// buffers that have usage `STORAGE`, too.
    pub geometry: Option<FrameGeometry<'a>>,
}

/// A geometry that may change between frames.
#[derive(Clone, Copy, Debug)]
pub struct FrameGeometry<'a> {
    /// The triangles.
    pub triangles: &'a Geometry,
    /// Another number whenever the triangles changed.
    pub revision: u64,
}
