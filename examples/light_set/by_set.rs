//! The shadows of a light set.

use super::program::{SceneShadows, SurfaceBuffer};
use crate::{
    renderer::{Boxes, Graphics},
    set::BoxShadows,
};
use anyhow::Result;
use umbrage::{
    glam::Affine3A,
    gpu::{
        DepthBuffer, MaskFormat, MaskInputs, MaskReceivers,
        wgpu::{BindGroup, BindGroupLayout, CommandEncoder, TextureView},
    },
};

impl SceneShadows for BoxShadows {
    fn place(&mut self, placements: &[Affine3A]) -> Result<()> {
        Self::place(self, placements)
    }

    fn encode(&mut self, _: &Graphics, boxes: &Boxes, encoder: &mut CommandEncoder) -> Result<()> {
        self.prepare(boxes)?;
        Ok(self.set.encode(encoder)?)
    }

    fn wgsl(&self) -> (u64, &str) {
        (self.set.wgsl_revision(), self.set.wgsl())
    }

    fn group(&self) -> Result<(&BindGroup, &BindGroupLayout)> {
        Ok(self.set.bind_group()?)
    }

    fn masks(
        &mut self,
        _: &Graphics,
        boxes: &Boxes,
        gbuffer: &SurfaceBuffer,
        encoder: &mut CommandEncoder,
    ) -> Result<TextureView> {
        let inputs = MaskInputs {
            size: boxes.scene.camera.size,
            receivers: MaskReceivers::Depth {
                depth: DepthBuffer {
                    depth: &gbuffer.depth,
                    world_from_clip: boxes.scene.clip_from_world().inverse(),
                    empty: 1.0,
                },
                // A constant bias needs no normals, and the program written by hand reads none for
                // its masks.
                normals: None,
            },
            lights: &self.lights,
            format: MaskFormat::Unorm8,
        };
        self.set.prepare_masks(&inputs)?;
        Ok(self.set.encode_masks(encoder)?.clone())
    }
}
