//! Readback of bytes and timestamps from the device, some frames later.

use anyhow::{Context as _, Result};
use std::sync::{Arc, OnceLock};

/// A buffer that is being read back.
pub(crate) struct Readback {
    buffer: wgpu::Buffer,
    /// `true` if the buffer could be mapped. Unset until that is known.
    is_mapped: Arc<OnceLock<bool>>,
}

impl Readback {
    /// Returns a buffer of [`Self::start`].
    pub(super) fn buffer(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        })
    }

    /// Starts to read a buffer, once the commands that fill it are submitted.
    pub(super) fn start(buffer: wgpu::Buffer) -> Self {
        let is_mapped = Arc::new(OnceLock::new());
        let outcome = is_mapped.clone();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            outcome.get_or_init(|| result.is_ok());
        });
        Self { buffer, is_mapped }
    }

    /// Returns the bytes when they are available.
    ///
    /// # Errors
    /// Returns an error if the device failed.
    pub(super) fn take(&self) -> Result<Option<Vec<u8>>> {
        let Some(is_mapped) = self.is_mapped.get() else {
            return Ok(None);
        };
        anyhow::ensure!(*is_mapped, "the device returned no results");
        let view = self.buffer.slice(..).get_mapped_range()?;
        Ok(Some(view.to_vec()))
    }
}

/// Pairs of timestamp queries.
pub(crate) struct Timestamps {
    pub queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    nanoseconds_per_tick: f64,
}

impl Timestamps {
    /// Creates the queries. Returns `None` if the device has no timestamps.
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, count: u32) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 8 * u64::from(count),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            nanoseconds_per_tick: f64::from(queue.get_timestamp_period()),
        })
    }

    /// Records the copy of the first queries into a buffer for reading.
    pub(super) fn resolve(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        count: u32,
    ) -> wgpu::Buffer {
        let bytes = 8 * u64::from(count);
        let buffer = Readback::buffer(device, bytes);
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &buffer, 0, bytes);
        buffer
    }

    /// Returns the time of each pair of queries, milliseconds, when they are available.
    ///
    /// # Errors
    /// Returns an error if the device failed.
    pub(super) fn take(&self, readback: &Readback) -> Result<Option<Vec<f64>>> {
        let Some(bytes) = readback.take()? else {
            return Ok(None);
        };
        let ticks = |bytes: &[u8; 8]| u64::from_le_bytes(*bytes);
        let milliseconds = |pair: &[[u8; 8]; 2]| {
            let passed = ticks(&pair[1]).saturating_sub(ticks(&pair[0]));
            passed as f64 * self.nanoseconds_per_tick * 1e-6
        };
        let pairs = bytes.as_chunks::<8>().0.as_chunks::<2>().0;
        Ok(Some(pairs.iter().map(milliseconds).collect()))
    }
}

/// Returns the 32-bit floats of an image whose rows are padded.
///
/// # Errors
/// Returns an error if there are fewer bytes.
pub(super) fn floats_of_rows(bytes: &[u8], width: usize, bytes_per_row: usize) -> Result<Vec<f32>> {
    let mut out = Vec::new();
    for row in bytes.chunks(bytes_per_row) {
        let row = row.get(..4 * width).context("a row is incomplete")?;
        let floats = row.as_chunks::<4>().0.iter();
        out.extend(floats.map(|bytes| f32::from_le_bytes(*bytes)));
    }
    Ok(out)
}
