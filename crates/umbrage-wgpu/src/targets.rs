//! What the light sees is drawn into: for the player's own draws, and for callers with their own vertex shaders.

use glam::{Mat4, UVec2};
use umbrage_core::{Cast, Cull, RasterBias};
use wgpu::{
    CompareFunction, DepthBiasState, DepthStencilState, Face, FrontFace, LoadOp, Operations, PrimitiveState,
    RenderPassDepthStencilAttachment, StencilState, StoreOp, TextureFormat, TextureView,
};

/// One cast to be drawn: begin a pass with [`attachment`](Self::attachment), and draw all casters with pipelines that have
/// [`primitive`](Self::primitive) and [`depth_stencil`](Self::depth_stencil) and whose vertex shader ends in
/// `clip_from_world * p_world`. Draw the targets in order: two may share a depth layer, and the first one clears it.
#[derive(Clone, Debug)]
pub struct CastTarget {
    /// One layer of a `Depth32Float` image, 1 where nothing casts.
    pub depth: TextureView,
    /// Its size, texels.
    pub size: UVec2,
    /// Whether this is the first cast into the layer.
    pub clears: bool,
    /// The light's view and projection.
    pub clip_from_world: Mat4,
    /// Faces left out.
    pub cull: Cull,
    /// Polygon offset.
    pub bias: RasterBias,
}

impl CastTarget {
    pub(crate) fn new(casts: &[Cast], index: usize, depth: &TextureView, size: UVec2) -> Self {
        let cast = &casts[index];
        Self {
            depth: depth.clone(),
            size,
            clears: !casts[..index].iter().any(|c| (c.image, c.layer) == (cast.image, cast.layer)),
            clip_from_world: cast.space.clip_from_world(),
            cull: cast.cull,
            bias: cast.bias,
        }
    }

    /// The depth attachment of the pass.
    pub fn attachment(&self) -> RenderPassDepthStencilAttachment<'_> {
        depth_attachment(&self.depth, self.clears)
    }

    /// Triangles, counter-clockwise seen from outside, with the target's culling.
    pub fn primitive(&self) -> PrimitiveState {
        self.state().primitive()
    }

    /// The nearest surface stays; the target's bias is added.
    pub fn depth_stencil(&self) -> DepthStencilState {
        self.state().depth_stencil()
    }

    pub(crate) fn state(&self) -> DepthState {
        let RasterBias { constant, slope, clamp } = self.bias;
        DepthState { cull: self.cull, constant, slope_bits: slope.to_bits(), clamp_bits: clamp.to_bits() }
    }
}

pub(crate) fn depth_attachment(view: &TextureView, clear: bool) -> RenderPassDepthStencilAttachment<'_> {
    let load = if clear { LoadOp::Clear(1.0) } else { LoadOp::Load };
    let depth_ops = Some(Operations { load, store: StoreOp::Store });
    RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
}

/// A target's fixed state; floats as bits, so that it can be a key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct DepthState {
    cull: Cull,
    constant: i32,
    slope_bits: u32,
    clamp_bits: u32,
}

impl DepthState {
    pub(crate) fn primitive(self) -> PrimitiveState {
        let cull_mode = match self.cull {
            Cull::None => None,
            Cull::Front => Some(Face::Front),
            Cull::Back => Some(Face::Back),
        };
        PrimitiveState { front_face: FrontFace::Ccw, cull_mode, ..PrimitiveState::default() }
    }

    pub(crate) fn depth_stencil(self) -> DepthStencilState {
        DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Less),
            stencil: StencilState::default(),
            bias: DepthBiasState {
                constant: self.constant,
                slope_scale: f32::from_bits(self.slope_bits),
                clamp: f32::from_bits(self.clamp_bits),
            },
        }
    }
}
