//! Masks that compute passes write, for kernels with long loops.

use crate::{
    light_set::{ids::LightKey, masks::MaskPass},
    receive::pixel_groups,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::extent,
        windows::Windows,
    },
};
use bytemuck::{Pod, Zeroable};
use glam::UVec2;
use std::num::NonZeroU64;
use umbrage_core::Invalid;
use wgpu::{
    BindGroup, Buffer, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoder,
    ComputePassDescriptor, ComputePassTimestampWrites, ComputePipeline, TexelCopyBufferInfo,
    TexelCopyBufferLayout, Texture, TextureFormat, TextureView,
};

/// Inputs of one mask in shaders; `UmbrageMask` is its twin.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct MaskChoice {
    /// Index of the light.
    light: u32,
    /// Layer of the masks.
    layer: u32,
    /// Size of the mask, pixels.
    size: [u32; 2],
}

/// A [`MaskChoice`].
const CHOICE_SLOT: Slot = Slot::Window(NonZeroU64::new(size_of::<MaskChoice>() as u64).unwrap());

/// Resources of the compute passes.
#[derive(Debug, Default)]
pub(crate) struct ComputedMasks {
    pub(crate) pipeline: Option<ComputePipeline>,
    /// The receivers, the choice of a light, and the output.
    pub(crate) binding: Binding,
    /// The choice of each layer.
    choices: Windows,
    /// Buffer of `choices`.
    choices_buffer: Option<Buffer>,
    /// A mask in bytes, which is copied to its layer. `None` for masks of floats.
    bytes: Option<Buffer>,
}

/// Groups of a compute pass: the set's and the masks' own, each with its index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MaskGroups<'a> {
    pub(crate) set: (u32, &'a BindGroup),
    pub(crate) own: u32,
}

impl ComputedMasks {
    /// Writes the choice of each layer. Returns whether its buffer is that of the last call.
    pub(crate) fn write_choices(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        lights: &[(LightKey, MaskPass)],
        size: UVec2,
    ) -> bool {
        let choices = (0..).zip(lights).map(|(layer, (_, pass))| {
            let light = match pass {
                MaskPass::Compute(light) => *light,
                // No compute pass reads this choice.
                MaskPass::Clear | MaskPass::Draw(_) => u32::MAX,
            };
            MaskChoice {
                light,
                layer,
                size: size.to_array(),
            }
        });
        let written = self.choices.write(factory, "umbrage masks", choices);
        let buffer = written.map(|(buffer, _)| buffer);
        let is_kept = self.choices_buffer == buffer;
        self.choices_buffer = buffer;
        is_kept
    }

    /// Replaces the buffer of a mask in bytes if it doesn't fit. `has_bytes` is false for masks of
    /// floats.
    ///
    /// Errors if shaders can't bind the bytes of a mask.
    pub(crate) fn fit_bytes(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        size: UVec2,
        has_bytes: bool,
    ) -> Result<(), Invalid> {
        if !has_bytes {
            self.bytes = None;
            return Ok(());
        }
        let bytes = u64::from(row_bytes(size.x)) * u64::from(size.y);
        if self.bytes.as_ref().is_some_and(|held| held.size() == bytes) {
            return Ok(());
        }
        let limits = factory.device.limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        if bytes > most {
            let why = format!("of {bytes} bytes each exceed the {most} that shaders can bind");
            let help = "use smaller masks, or `MaskFormat::Float32`";
            return Err(Invalid::new("masks", why, help));
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        self.bytes = Some(factory.buffer("umbrage masks", usage, bytes));
        Ok(())
    }

    /// Returns the bindings after those of the receivers: the choice, and the output, which is the
    /// buffer of bytes or `masks`.
    pub(crate) fn entries(&self, masks: &TextureView) -> Vec<(Slot, Bound)> {
        let choices = self.choices_buffer.iter().cloned();
        let mut entries: Vec<_> = choices
            .map(|buffer| (CHOICE_SLOT, Bound::of_slot(CHOICE_SLOT, buffer)))
            .collect();
        let floats = Slot::Stored {
            format: TextureFormat::R32Float,
            layered: true,
        };
        entries.push(match &self.bytes {
            Some(bytes) => (Slot::Written, Bound::Buffer(bytes.clone())),
            None => (floats, Bound::View(masks.clone())),
        });
        entries
    }

    /// Records the pass of a layer, and the copy of its bytes. Records nothing before the pipeline
    /// is prepared.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        groups: MaskGroups<'_>,
        texture: &Texture,
        layer: u32,
        timestamp_writes: Option<ComputePassTimestampWrites<'_>>,
    ) {
        let Some(pipeline) = &self.pipeline else {
            return;
        };
        let size = UVec2::new(texture.width(), texture.height());
        let [columns, rows] = pixel_groups(size);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("umbrage mask"),
            timestamp_writes,
        });
        pass.set_pipeline(pipeline);
        let (set_index, set_group) = groups.set;
        pass.set_bind_group(set_index, set_group, &[]);
        let choice = self.choices.offset(layer as usize);
        pass.set_bind_group(groups.own, self.binding.group(), &[choice]);
        pass.dispatch_workgroups(columns, rows, 1);
        drop(pass);
        if let Some(bytes) = &self.bytes {
            copy_mask(encoder, bytes, texture, layer);
        }
    }
}

/// Returns the bytes from one row of a mask in bytes to the next.
fn row_bytes(width: u32) -> u32 {
    width.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Records the copy of a mask's bytes into its layer.
fn copy_mask(encoder: &mut CommandEncoder, bytes: &Buffer, texture: &Texture, layer: u32) {
    let from = TexelCopyBufferInfo {
        buffer: bytes,
        layout: TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes(texture.width())),
            rows_per_image: None,
        },
    };
    let mut to = texture.as_image_copy();
    to.origin.z = layer;
    let size = UVec2::new(texture.width(), texture.height());
    encoder.copy_buffer_to_texture(from, to, extent(size, 1));
}
