//! A light's mask for given receivers, made by a light set on the device and read back when it is there.

use super::pipelines;
use anyhow::Result;
use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering},
};
use umbrage::{
    Receivers,
    glam::UVec2,
    wgpu::{GBuffer, LightId, LightSet, MaskFormat, MaskInputs, SetReceivers, SetTimestamps},
};

/// Receivers as textures.
pub(crate) struct ReceiverTextures {
    size: UVec2,
    position: wgpu::TextureView,
    normal: wgpu::TextureView,
    triangle: wgpu::TextureView,
}

impl ReceiverTextures {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, receivers: &Receivers) -> Self {
        let size = receivers.size;
        let upload = |format, bytes: &[u8]| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
            let texture = pipelines::texture(device, size, format, usage, &[]);
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((bytes.len() / size.y as usize) as u32),
                rows_per_image: None,
            };
            queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let count = receivers.len();
        let position = |i: usize| {
            let receives = if receivers.receives[i] { 1.0 } else { 0.0 };
            receivers.position(i).extend(receives).to_array()
        };
        let positions: Vec<[f32; 4]> = (0..count).map(position).collect();
        let normals: Vec<[f32; 4]> = (0..count)
            .map(|i| receivers.normal(i).extend(0.0).to_array())
            .collect();
        let floats = wgpu::TextureFormat::Rgba32Float;
        Self {
            size,
            position: upload(floats, bytemuck::cast_slice(&positions)),
            normal: upload(floats, bytemuck::cast_slice(&normals)),
            triangle: upload(
                wgpu::TextureFormat::R32Uint,
                bytemuck::cast_slice(&receivers.triangle),
            ),
        }
    }
}

const UNDER_WAY: u8 = 0;
const READY: u8 = 1;
const FAILED: u8 = 2;

/// A mask that is on its way from the device.
pub(crate) struct PendingMask {
    size: UVec2,
    bytes_per_row: u32,
    /// The mask's rows, and behind them two timestamps.
    buffer: wgpu::Buffer,
    /// Nanoseconds from one count of the device's clock to the next; none where it has none.
    tick: Option<f64>,
    state: Arc<AtomicU8>,
}

/// A mask that is there.
pub(crate) struct ReadMask {
    /// Rows from the top.
    pub mask: Vec<f32>,
    /// What all its lookups took on the device, milliseconds; none where that has no clock.
    pub milliseconds: Option<f64>,
}

/// Two timestamps around the mask's passes.
struct MaskClock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl MaskClock {
    fn new(device: &wgpu::Device) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("mask"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("mask's time"),
                size: STAMPS,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        })
    }
}

/// Bytes of two timestamps.
const STAMPS: u64 = 16;

impl PendingMask {
    /// Records and submits the passes that make a light's mask. The set must have been prepared.
    ///
    /// # Errors
    /// Errors if the set does.
    pub(crate) fn request(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        set: &mut LightSet,
        light: LightId,
        receivers: &ReceiverTextures,
    ) -> Result<Self> {
        let size = receivers.size;
        let inputs = MaskInputs {
            size,
            receivers: SetReceivers::Positions(GBuffer {
                position: &receivers.position,
                normal: &receivers.normal,
                triangle: Some(&receivers.triangle),
            }),
            lights: &[light],
            format: MaskFormat::Float32,
        };
        set.prepare_masks(queue, &inputs)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let clock = MaskClock::new(device);
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
        let alignment = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
        let bytes_per_row = (4 * size.x).next_multiple_of(alignment);
        let bytes = u64::from(bytes_per_row) * u64::from(size.y);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("mask"),
            size: bytes + STAMPS,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let to = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(bytes_per_row),
                rows_per_image: None,
            },
        };
        let extent = wgpu::Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        };
        encoder.copy_texture_to_buffer(mask.texture().as_image_copy(), to, extent);
        let mut tick = None;
        // Nothing is timed where the light has no shadow to look up.
        if let Some(clock) = clock.filter(|_| !passes.is_empty()) {
            encoder.resolve_query_set(&clock.queries, 0..2, &clock.resolved, 0);
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &buffer, bytes, STAMPS);
            tick = Some(f64::from(queue.get_timestamp_period()));
        }
        queue.submit([encoder.finish()]);
        let state = Arc::new(AtomicU8::new(UNDER_WAY));
        let told = state.clone();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            let outcome = if result.is_ok() { READY } else { FAILED };
            told.store(outcome, Ordering::Release);
        });
        Ok(Self {
            size,
            bytes_per_row,
            buffer,
            tick,
            state,
        })
    }

    /// Returns the mask once it is there.
    ///
    /// # Errors
    /// Errors if the device gave it up.
    pub(crate) fn take(&self) -> Result<Option<ReadMask>> {
        match self.state.load(Ordering::Acquire) {
            UNDER_WAY => return Ok(None),
            READY => {}
            _ => anyhow::bail!("the device didn't hand out a mask"),
        }
        let view = self.buffer.slice(..).get_mapped_range()?;
        let mut mask = Vec::with_capacity((self.size.x * self.size.y) as usize);
        let (rows, stamps) = view.split_at(view.len() - STAMPS as usize);
        for row in rows.chunks(self.bytes_per_row as usize) {
            let row = &row[..4 * self.size.x as usize];
            mask.extend(
                row.as_chunks::<4>()
                    .0
                    .iter()
                    .map(|&bytes| f32::from_le_bytes(bytes)),
            );
        }
        let stamps = stamps.as_chunks::<8>().0;
        let milliseconds = self.tick.map(|tick| {
            let [begin, end] = [0, 1].map(|i| u64::from_le_bytes(stamps[i]));
            end.saturating_sub(begin) as f64 * tick * 1e-6
        });
        drop(view);
        self.buffer.unmap();
        Ok(Some(ReadMask { mask, milliseconds }))
    }
}
