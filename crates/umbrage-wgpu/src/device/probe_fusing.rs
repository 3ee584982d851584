//! Probe of a device's rounding of products before sums, which WGSL leaves to drivers.

use crate::{
    device::probe_image::{draw_and_read, record_draw},
    resources::pipelines::{Targets, fullscreen_pipeline},
    wgsl::stages::shader_of,
};
use umbrage_core::{BackendError, Fusing};
use wgpu::{Device, Queue, TextureFormat};

const LABEL: &str = "umbrage probe of fusing";

/// Numbers to test each expression with.
const COLUMNS: usize = 4;

/// Computes sums on a device and returns its rounding. Takes a few milliseconds.
///
/// # Errors
/// Errors if the device fails.
pub fn probe_fusing(device: &Device, queue: &Queue) -> Result<Fusing, BackendError> {
    let sums = draw(device, queue)?;
    let is_fused = |row: usize| {
        let row = &sums[row * COLUMNS..][..COLUMNS];
        (0..COLUMNS).any(|column| row[column] == unrounded_sum(column))
    };
    Ok(Fusing {
        product_and_sum: is_fused(0),
        fma: is_fused(1),
        guarded_product: Some(is_fused(2)),
    })
}

/// Returns the sum of a column if the product is not rounded; otherwise the sum is 0.
fn unrounded_sum(column: usize) -> f32 {
    let e = (column + 1) as f32 / 32_768.0;
    e * e
}

/// Returns the sums, row by row.
fn draw(device: &Device, queue: &Queue) -> Result<Vec<f32>, BackendError> {
    let format = TextureFormat::R32Float;
    let text = shader_of(&["probe_fusing"]);
    let pipeline = fullscreen_pipeline(
        device,
        LABEL,
        &text,
        ["umbrage_fullscreen", "product_and_sum"],
        &Targets::Colors(&[format]),
        &[],
    );
    let size = [COLUMNS as u32, 3];
    draw_and_read(device, queue, LABEL, size, format, |encoder, view| {
        record_draw(encoder, view, &pipeline, 3);
    })
}
