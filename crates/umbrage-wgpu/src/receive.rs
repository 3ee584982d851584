//! The receive stage: the recipe's kernel, run for every pixel of the G-buffer.

use crate::{
    filter::color_attachment,
    frame::{FrameInputs, GBuffer, RendererOptions},
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::{GpuImage, fit_images},
        kernel_stage::{KernelStage, Sources},
        pipelines::Pipelines,
        timestamps::{PassTimestamps, TimedStage, pass_stamps},
    },
    wgsl::{kernel::kernel_wgsl, stages::receive_shader},
};
use umbrage_core::{Format, ImageDesc};
use wgpu::{
    BindGroup, BindGroupLayout, Color, CommandEncoder, RenderPassDescriptor, ShaderStages,
    TextureFormat, TextureView,
};

/// The receive stage, ready to be encoded.
#[derive(Debug, Default)]
pub(crate) struct ReceiveStage {
    kernel: KernelStage,
    gbuffer: Binding,
    mask: Vec<GpuImage>,
}

impl ReceiveStage {
    /// Makes the mask, the bindings and the pipeline. Returns the mask that will be written.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        options: RendererOptions,
        frame: &FrameInputs<'_>,
    ) -> &GpuImage {
        let mask = ImageDesc {
            label: "umbrage mask",
            size: frame.size,
            layers: 1,
            format: Format::R32,
        };
        fit_images(factory, &mut self.mask, &[mask], &[]);
        let receive = &sources.recipe.receive;
        let shape = self.kernel.bind(
            factory,
            pipelines,
            sources,
            &*receive.kernel,
            &receive.inputs,
            &receive.tables,
        );
        let (slots, bound) = gbuffer(&frame.receivers);
        let layout = pipelines
            .layouts
            .get(factory, ShaderStages::FRAGMENT, &slots);
        self.gbuffer
            .set(factory, "umbrage receivers", &layout, bound);
        let kernel_text = kernel_wgsl(&*receive.kernel, &shape, options.kernel_group);
        let has_triangles = frame.receivers.triangle.is_some();
        let text = receive_shader(&kernel_text, options.gbuffer_group(), has_triangles);
        let groups = groups(options, &self.kernel, &layout);
        self.kernel.pipeline = Some(pipelines.kernel(
            factory,
            "umbrage receive",
            text,
            "umbrage_receive",
            TextureFormat::R32Float,
            &groups,
        ));
        &self.mask[0]
    }

    /// Records the pass and returns the mask.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        options: RendererOptions,
        stamps: Option<&PassTimestamps<'_>>,
    ) -> Option<&TextureView> {
        let mask = &self.mask()?.whole;
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage receive"),
            color_attachments: &[Some(color_attachment(mask, Color::WHITE))],
            timestamp_writes: pass_stamps(stamps, TimedStage::Receive, 0, 1),
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(self.kernel.pipeline.as_ref()?);
        pass.set_bind_group(options.kernel_group, self.kernel.binding.group(), &[]);
        pass.set_bind_group(options.gbuffer_group(), self.gbuffer.group(), &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        Some(mask)
    }

    pub(crate) fn mask(&self) -> Option<&GpuImage> {
        self.mask.first()
    }

    /// Returns the bind group of what the kernel reads; `None` before anything is prepared.
    pub(crate) fn kernel_group(&self) -> Option<(&BindGroup, &BindGroupLayout)> {
        self.kernel
            .binding
            .group()
            .zip(self.kernel.binding.layout())
    }
}

/// Returns the G-buffer's bindings, kinds and views: positions, normals, and triangle ids if there are any.
pub(crate) fn gbuffer(receivers: &GBuffer<'_>) -> (Vec<Slot>, Vec<Bound>) {
    let floats = Slot::Floats { layered: false };
    let mut slots = vec![floats, floats];
    let mut views = vec![
        Bound::View(receivers.position.clone()),
        Bound::View(receivers.normal.clone()),
    ];
    if let Some(triangle) = receivers.triangle {
        slots.push(Slot::Whole { layered: false });
        views.push(Bound::View(triangle.clone()));
    }
    (slots, views)
}

/// Returns the bind group layouts of a pipeline that runs a kernel over a G-buffer.
pub(crate) fn groups<'a>(
    options: RendererOptions,
    kernel: &'a KernelStage,
    gbuffer: &'a BindGroupLayout,
) -> Vec<Option<&'a BindGroupLayout>> {
    let mut groups = vec![None; options.kernel_group.max(1) as usize + 1];
    groups[options.kernel_group as usize] = kernel.binding.layout();
    groups[options.gbuffer_group() as usize] = Some(gbuffer);
    groups
}
