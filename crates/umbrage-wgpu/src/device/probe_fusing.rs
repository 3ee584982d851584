//! Finds out whether a device rounds a product before it adds something to it: WGSL leaves that to drivers.

use crate::{
    device::readback::{ReadBack, Spare},
    filter::color_attachment,
    resources::{
        counters::{Counters, ResourceFactory},
        pipelines::{Targets, fullscreen_pipeline},
    },
    wgsl::stages::FULLSCREEN,
};
use umbrage_core::{BackendError, Fusing, MATH};
use wgpu::{
    Color, CommandEncoderDescriptor, Device, Extent3d, Queue, RenderPassDescriptor,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
};

const LABEL: &str = "umbrage probe of fusing";

/// Numbers that each way is tried with.
const COLUMNS: usize = 4;

/// Computes sums on a device and returns how it rounded them. Takes some milliseconds.
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

/// Returns the sum of a column if the product is not rounded; else it is 0.
fn unrounded_sum(column: usize) -> f32 {
    let e = (column + 1) as f32 / 32_768.0;
    e * e
}

/// Returns the sums, row by row.
fn draw(device: &Device, queue: &Queue) -> Result<Vec<f32>, BackendError> {
    let mut counters = Counters::default();
    let mut spare = Spare::default();
    let mut factory = ResourceFactory {
        device,
        queue,
        counters: &mut counters,
    };
    let format = TextureFormat::R32Float;
    let image = factory.texture(&TextureDescriptor {
        label: Some(LABEL),
        size: Extent3d {
            width: COLUMNS as u32,
            height: 3,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let text = [
        MATH.text,
        FULLSCREEN.text,
        include_str!("probe_fusing.wgsl"),
    ]
    .concat();
    let pipeline = fullscreen_pipeline(
        device,
        LABEL,
        &text,
        ["umbrage_fullscreen", "product_and_sum"],
        &Targets::Colors(&[format]),
        &[],
    );
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    let view = image.create_view(&TextureViewDescriptor::default());
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some(LABEL),
        color_attachments: &[Some(color_attachment(&view, Color::TRANSPARENT))],
        ..RenderPassDescriptor::default()
    });
    pass.set_pipeline(&pipeline);
    pass.draw(0..3, 0..1);
    drop(pass);
    let mut back = ReadBack::new(device, &mut counters, &mut spare);
    let ticket = back.texture(&mut encoder, &image);
    queue.submit([encoder.finish()]);
    back.wait()?;
    back.read(ticket)
}
