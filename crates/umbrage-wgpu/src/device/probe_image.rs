//! Small images that probes draw and read back.

use crate::{
    device::readback::{ReadBack, Spare},
    filter::color_attachment,
    resources::counters::{Counters, ResourceFactory},
};
use bytemuck::Pod;
use umbrage_core::BackendError;
use wgpu::{
    Color, CommandEncoder, CommandEncoderDescriptor, Device, Extent3d, Queue, RenderPassDescriptor,
    RenderPipeline, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
};

/// Draws an image and returns its texels, row by row. `record` records the pass that draws into the
/// view.
///
/// # Errors
/// Errors if the device fails.
pub(crate) fn draw_and_read<T: Pod>(
    device: &Device,
    queue: &Queue,
    label: &str,
    size: [u32; 2],
    format: TextureFormat,
    record: impl FnOnce(&mut CommandEncoder, &TextureView),
) -> Result<Vec<T>, BackendError> {
    let mut counters = Counters::default();
    let mut spare = Spare::default();
    let [width, height] = size;
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let mut factory = ResourceFactory::new(device, queue, &mut counters);
    let image = factory.texture(label, size, format, usage);
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    let view = image.create_view(&TextureViewDescriptor::default());
    record(&mut encoder, &view);
    let mut back = ReadBack::new(device, &mut counters, &mut spare);
    let ticket = back.texture(&mut encoder, &image);
    queue.submit([encoder.finish()]);
    back.wait()?;
    back.read(ticket)
}

/// Records a pass that draws with this pipeline into a colour target.
pub(crate) fn record_draw(
    encoder: &mut CommandEncoder,
    view: &TextureView,
    pipeline: &RenderPipeline,
    vertices: u32,
) {
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        color_attachments: &[Some(color_attachment(view, Color::TRANSPARENT))],
        ..RenderPassDescriptor::default()
    });
    pass.set_pipeline(pipeline);
    pass.draw(0..vertices, 0..1);
}
