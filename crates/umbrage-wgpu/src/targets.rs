//! The layers that casts draw into, for the renderer and for callers with their own vertex shaders.

use crate::resources::images::GpuImage;
use glam::{Mat4, UVec2};
use umbrage_core::{CameraRays, Cast, CastMode, Cull, Format, LightSpace, RasterBias, Source};
use wgpu::{
    CompareFunction, DepthBiasState, DepthStencilState, Face, FrontFace, LoadOp, Operations,
    PrimitiveState, RenderPassDepthStencilAttachment, StencilFaceState, StencilOperation,
    StencilState, StoreOp, TextureFormat, TextureView,
};

/// The target of one cast. Begin a pass with [`attachment`](Self::attachment), and draw all casters
/// (or [`everything`](Self::everything)). Pipelines need [`primitive`](Self::primitive) and
/// [`depth_stencil`](Self::depth_stencil), and a vertex shader that ends in
/// `clip_from_world * p_world`. Draw the targets in order: two may share a layer, the first one
/// clears it, and later ones may read what earlier ones drew.
#[derive(Clone, Debug)]
pub struct CastTarget {
    /// Layer to attach: depth, 1 in empty texels; or depth and counts.
    pub layer: TextureView,
    /// Size in texels.
    pub size: UVec2,
    /// True if this is the first cast into the layer.
    pub clears: bool,
    /// The light's view and projection.
    pub clip_from_world: Mat4,
    /// True to draw all geometry that the camera may see, not only casters.
    pub everything: bool,
    /// Layer to peel, for depth peeling: a `texture_2d<f32>` for fragment shaders, not filterable.
    /// The pipeline then needs a fragment shader without outputs that discards the fragments that
    /// are not behind it:
    /// `if at.z <= textureLoad(behind, vec2i(at.xy), 0).x { discard; }`
    /// Here `at` is `@builtin(position)`. In a [`Format::Depth16`] image, compare both sides as
    /// `round(65535.0 * z)`.
    pub behind: Option<TextureView>,
    /// Face culling.
    pub cull: Cull,
    /// Polygon offset.
    pub bias: RasterBias,
    space: LightSpace,
    format: Format,
}

impl CastTarget {
    pub(crate) fn new(casts: &[Cast], index: usize, images: &[GpuImage]) -> Self {
        let cast = &casts[index];
        let mut target = Self::plain(casts, index, &images[cast.image]);
        if let CastMode::DepthPeel(other) = cast.mode {
            target.behind = Some(images[other].reads[cast.layer as usize].clone());
        }
        target
    }

    /// Returns the target of a cast that doesn't peel.
    fn plain(casts: &[Cast], index: usize, image: &GpuImage) -> Self {
        let cast = &casts[index];
        let is_drawn_before = casts[..index]
            .iter()
            .any(|earlier| earlier.image == cast.image && earlier.layer == cast.layer);
        Self {
            layer: image.layers[cast.layer as usize].clone(),
            size: image.desc.size,
            clears: !is_drawn_before,
            clip_from_world: cast.space.clip_from_world(),
            everything: matches!(cast.source, Source::Everything),
            behind: None,
            cull: cast.cull,
            bias: cast.bias,
            space: cast.space,
            format: image.desc.format,
        }
    }

    /// Returns the rays through the centres of the layer's texels, for alpha tests in the program's
    /// shader with [`CutOutBuffers::wgsl`](crate::CutOutBuffers::wgsl).
    pub fn rays(&self) -> CameraRays {
        self.space.rays(self.size)
    }

    /// Returns the depth-stencil attachment of the pass.
    pub fn attachment(&self) -> RenderPassDepthStencilAttachment<'_> {
        self.attachment_that(self.clears)
    }

    /// Returns [`attachment`](Self::attachment) for a pass that clears the layer first, or does
    /// not.
    pub(crate) fn attachment_that(&self, clears: bool) -> RenderPassDepthStencilAttachment<'_> {
        attachment(&self.layer, self.format, clears)
    }

    /// Returns the primitive state: triangles, counter-clockwise seen from outside, with the
    /// target's culling.
    pub fn primitive(&self) -> PrimitiveState {
        self.state().primitive()
    }

    /// Returns the depth-stencil state: keeps the nearest surface, with the target's bias added, or
    /// counts surfaces that are not in front of the depth.
    pub fn depth_stencil(&self) -> DepthStencilState {
        self.state().depth_stencil()
    }

    /// Returns a key for caches of pipelines: targets with equal keys need equal pipelines.
    pub fn key(&self) -> CastTargetKey {
        CastTargetKey {
            depth: self.state(),
            peels: self.behind.is_some(),
        }
    }

    /// Returns the same target with another layer, which is cleared first.
    pub(crate) fn with_layer(&self, layer: TextureView) -> Self {
        let mut other = self.clone();
        other.layer = layer;
        other.clears = true;
        other
    }

    pub(crate) fn state(&self) -> DepthState {
        let RasterBias {
            constant,
            slope,
            clamp,
        } = self.bias;
        DepthState {
            format: self.layer.texture().format(),
            counts: self.format == Format::Stencil8,
            cull: self.cull,
            constant,
            slope_bits: slope.to_bits(),
            clamp_bits: clamp.to_bits(),
        }
    }

    /// Returns the format of the target image.
    pub(crate) fn format(&self) -> Format {
        self.format
    }
}

/// Key of the pipelines that draw into a [`CastTarget`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CastTargetKey {
    depth: DepthState,
    peels: bool,
}

/// Returns the attachment of a layer of an image of depth or counts; the other aspect of a shared
/// texture is read-only.
pub(crate) fn attachment(
    view: &TextureView,
    format: Format,
    clear: bool,
) -> RenderPassDepthStencilAttachment<'_> {
    let is_depth = format.is_depth();
    RenderPassDepthStencilAttachment {
        view,
        depth_ops: is_depth.then_some(operations(clear, 1.0)),
        stencil_ops: (!is_depth).then_some(operations(clear, 0)),
    }
}

/// Returns the operations of an attachment that is stored: clears it to `value` first, or loads its
/// contents.
fn operations<V>(clear: bool, value: V) -> Operations<V> {
    let load = if clear {
        LoadOp::Clear(value)
    } else {
        LoadOp::Load
    };
    Operations {
        load,
        store: StoreOp::Store,
    }
}

/// Fixed state of a target; floats are stored as bits, so that it can be a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct DepthState {
    format: TextureFormat,
    counts: bool,
    cull: Cull,
    constant: i32,
    slope_bits: u32,
    clamp_bits: u32,
}

impl DepthState {
    /// Keeps the nearest surface, of either side, without bias.
    pub(crate) const DEPTH_LESS: Self = Self {
        format: TextureFormat::Depth32Float,
        counts: false,
        cull: Cull::None,
        constant: 0,
        slope_bits: 0,
        clamp_bits: 0,
    };

    /// Returns the state that keeps the nearest surface, of either side, with a polygon offset of
    /// this number of units.
    pub(crate) const fn with_constant_offset(format: TextureFormat, units: i32) -> Self {
        Self {
            format,
            constant: units,
            ..Self::DEPTH_LESS
        }
    }

    pub(crate) fn primitive(self) -> PrimitiveState {
        let cull_mode = match self.cull {
            Cull::None => None,
            Cull::Front => Some(Face::Front),
            Cull::Back => Some(Face::Back),
        };
        PrimitiveState {
            front_face: FrontFace::Ccw,
            cull_mode,
            ..PrimitiveState::default()
        }
    }

    pub(crate) fn depth_stencil(self) -> DepthStencilState {
        DepthStencilState {
            format: self.format,
            depth_write_enabled: Some(!self.counts),
            depth_compare: Some(CompareFunction::Less),
            stencil: if self.counts {
                depth_fail_counting()
            } else {
                StencilState::default()
            },
            bias: DepthBiasState {
                constant: self.constant,
                slope_scale: f32::from_bits(self.slope_bits),
                clamp: f32::from_bits(self.clamp_bits),
            },
        }
    }
}

/// Returns the stencil state of Everitt and Kilgard 2002, "Practical and robust stenciled shadow
/// volumes": where the depth test fails, back faces count up and front faces down, modulo 256.
fn depth_fail_counting() -> StencilState {
    let front = StencilFaceState {
        compare: CompareFunction::Always,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::DecrementWrap,
        pass_op: StencilOperation::Keep,
    };
    let back = StencilFaceState {
        depth_fail_op: StencilOperation::IncrementWrap,
        ..front
    };
    StencilState {
        front,
        back,
        read_mask: 0xff,
        write_mask: 0xff,
    }
}
