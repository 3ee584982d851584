//! A light's mask for given receivers, computed by a light set on the device and read back.

use super::{
    pipelines,
    readback::{Readback, Timestamps, floats_of_rows},
};
use anyhow::Result;
use umbrage::{
    Receivers,
    glam::UVec2,
    gpu::{GBuffer, LightId, LightSet, MaskFormat, MaskInputs, MaskReceivers, SetTimestamps},
};

/// Receivers as textures.
pub(crate) struct ReceiverTextures {
    size: UVec2,
    position: wgpu::TextureView,
    normal: wgpu::TextureView,
    triangle: wgpu::TextureView,
}

impl ReceiverTextures {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, receivers: &Receivers) -> Self {
        let size = receivers.size;
        let upload = |format, bytes: &[u8]| pipelines::upload(device, queue, size, format, bytes);
        let position = |i: usize| {
            let receives = f32::from(u8::from(receivers.receives[i]));
            receivers.position(i).extend(receives).to_array()
        };
        let normal = |i: usize| receivers.normal(i).extend(0.0).to_array();
        let positions: Vec<[f32; 4]> = (0..receivers.len()).map(position).collect();
        let normals: Vec<[f32; 4]> = (0..receivers.len()).map(normal).collect();
        let floats = wgpu::TextureFormat::Rgba32Float;
        let ids = wgpu::TextureFormat::R32Uint;
        Self {
            size,
            position: upload(floats, bytemuck::cast_slice(&positions)),
            normal: upload(floats, bytemuck::cast_slice(&normals)),
            triangle: upload(ids, bytemuck::cast_slice(&receivers.triangle)),
        }
    }
}

/// A mask that is being read back from the device.
pub(crate) struct PendingMask {
    size: UVec2,
    bytes_per_row: u32,
    mask: Readback,
    /// Timestamps around the mask's pass. `None` without timestamps, on software adapters, and if
    /// the light has no shadows.
    time: Option<(Timestamps, Readback)>,
}

impl PendingMask {
    /// Records and submits the passes for a light's mask. The set must have been prepared.
    ///
    /// # Errors
    /// Returns an error if the set does.
    pub(super) fn request(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        set: &mut LightSet,
        light: LightId,
        receivers: &ReceiverTextures,
    ) -> Result<Self> {
        // Prepare the mask of the light.
        let size = receivers.size;
        let inputs = MaskInputs {
            size,
            receivers: MaskReceivers::Positions(GBuffer {
                position: &receivers.position,
                normal: &receivers.normal,
                triangle: Some(&receivers.triangle),
            }),
            lights: &[light],
            format: MaskFormat::Float32,
        };
        set.prepare_masks(&inputs)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // Record its passes, with timestamps if available. On lavapipe those of computed masks are
        // wrong after the first ones, .03 ms instead of 47, for an unknown reason.
        let is_software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let clock = if is_software {
            None
        } else {
            Timestamps::new(device, queue, 2)
        };
        let mut passes = Vec::new();
        let mask = match &clock {
            Some(clock) => {
                let stamps = SetTimestamps {
                    queries: &clock.queries,
                    range: 0..2,
                };
                set.encode_masks_timed(&mut encoder, &stamps, &mut passes)?
            }
            None => set.encode_masks(&mut encoder)?,
        };
        // Copy the mask and the timestamps to buffers.
        let bytes_per_row = (4 * size.x).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = Readback::buffer(device, u64::from(bytes_per_row) * u64::from(size.y));
        let to = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(bytes_per_row),
                rows_per_image: None,
            },
        };
        let from = mask.texture().as_image_copy();
        encoder.copy_texture_to_buffer(from, to, pipelines::extent(size));
        let clock = clock.filter(|_| !passes.is_empty()).map(|clock| {
            let stamps = clock.resolve(device, &mut encoder, 2);
            (clock, stamps)
        });
        // Submit, and start to read back.
        queue.submit([encoder.finish()]);
        Ok(Self {
            size,
            bytes_per_row,
            mask: Readback::start(buffer),
            time: clock.map(|(clock, stamps)| (clock, Readback::start(stamps))),
        })
    }

    /// Returns the mask, rows from the top, and the device time of all its lookups, milliseconds,
    /// when they are available.
    ///
    /// # Errors
    /// Returns an error if the device failed.
    pub(crate) fn take(&self) -> Result<Option<(Vec<f32>, Option<f64>)>> {
        let milliseconds = match &self.time {
            Some((clock, stamps)) => match clock.take(stamps)? {
                Some(times) => times.first().copied(),
                None => return Ok(None),
            },
            None => None,
        };
        let Some(bytes) = self.mask.take()? else {
            return Ok(None);
        };
        let (width, bytes_per_row) = (self.size.x as usize, self.bytes_per_row as usize);
        let mask = floats_of_rows(&bytes, width, bytes_per_row)?;
        Ok(Some((mask, milliseconds)))
    }
}
