//! The receive and shade stages, which run a kernel for every pixel of the G-buffer: in a render
//! pass, or in a compute pass for kernels with `ReceiveKernel::in_compute`.

use crate::{
    filter::color_attachment,
    frame::{FrameInputs, GBuffer, RendererOptions},
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::{GpuImage, fit_images, texture_format},
        kernel_stage::{KernelStage, Sources},
        pipelines::Pipelines,
        timestamps::of_compute,
    },
    wgsl::{
        kernel::kernel_wgsl,
        stages::{receive_shader, shade_shader},
    },
};
use glam::UVec2;
use umbrage_core::{Format, ImageDesc, Kernel};
use wgpu::{
    BindGroup, BindGroupLayout, Color, CommandEncoder, ComputePassDescriptor, ComputePipeline,
    RenderPassDescriptor, RenderPassTimestampWrites, RenderPipeline, ShaderStages,
};

/// A stage that writes one image, prepared for encoding. It has no image if the recipe lacks the
/// stage.
#[derive(Debug, Default)]
pub(crate) struct PixelStage {
    kernel: KernelStage,
    gbuffer: Binding,
    image: Vec<GpuImage>,
    pipeline: Option<PixelPipeline>,
    /// Clear colour of the image, for render passes.
    background: Color,
}

/// Pipeline of a stage that writes one image.
#[derive(Debug)]
enum PixelPipeline {
    Draw(RenderPipeline),
    Compute(ComputePipeline),
}

/// Kind of a stage's pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PixelPass {
    Draw,
    /// Stores to the image, which is the last binding of the G-buffer's group.
    Compute,
}

/// A stage's kernel, and its image.
struct PixelKernel<'a> {
    kernel: &'a dyn Kernel,
    images: &'a [usize],
    tables: &'a [usize],
    label: &'static str,
    size: UVec2,
    format: Format,
    entry: &'static str,
    pass: PixelPass,
}

impl PixelStage {
    /// Prepares the receive stage. Returns the mask that it writes.
    pub(crate) fn prepare_receive(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        options: RendererOptions,
        frame: &FrameInputs<'_>,
    ) -> Option<&GpuImage> {
        let receive = &sources.recipe.receive;
        let computes = receive.kernel.in_compute();
        let kernel = PixelKernel {
            kernel: &*receive.kernel,
            images: &receive.inputs,
            tables: &receive.tables,
            label: "umbrage mask",
            size: frame.size,
            format: Format::R32,
            entry: "umbrage_receive",
            pass: if computes {
                PixelPass::Compute
            } else {
                PixelPass::Draw
            },
        };
        let seen = gbuffer_entries(&frame.receivers);
        let has_triangles = frame.receivers.triangle.is_some();
        let shader = |text: &str, group| receive_shader(text, group, has_triangles, computes);
        self.background = Color::WHITE;
        self.prepare(factory, pipelines, sources, options, kernel, seen, shader);
        self.image()
    }

    /// Prepares the shade stage, if the recipe has one.
    pub(crate) fn prepare_shade(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        options: RendererOptions,
        frame: &FrameInputs<'_>,
        mask: &GpuImage,
    ) {
        let Some(shade) = &sources.recipe.shade else {
            return *self = Self::default();
        };
        let kernel = PixelKernel {
            kernel: &*shade.kernel,
            images: &[],
            tables: &shade.tables,
            label: "umbrage picture",
            size: frame.size,
            format: Format::Rgba32,
            entry: "umbrage_shade",
            pass: PixelPass::Draw,
        };
        let mut seen = gbuffer_entries(&frame.receivers);
        let view = Bound::View(mask.whole.clone());
        seen.push((Slot::Floats { layered: false }, view));
        let [r, g, b, a] = shade.background.map(f64::from);
        self.background = Color { r, g, b, a };
        self.prepare(
            factory,
            pipelines,
            sources,
            options,
            kernel,
            seen,
            shade_shader,
        );
    }

    /// Creates the image, the bindings and the pipeline. `shader` returns the text, given the
    /// kernel's text and the group of `seen`.
    #[expect(clippy::too_many_arguments, reason = "the two stages share all of it")]
    fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        options: RendererOptions,
        pixel: PixelKernel<'_>,
        mut seen: Vec<(Slot, Bound)>,
        shader: impl Fn(&str, u32) -> String,
    ) {
        // Create the image.
        let image = ImageDesc {
            label: pixel.label,
            size: pixel.size,
            layers: 1,
            format: pixel.format,
        };
        let computes = pixel.pass == PixelPass::Compute;
        fit_images(factory, &mut self.image, &[image], &[], |_| computes);
        // Bind the kernel's inputs and the receivers.
        let shape = self.kernel.bind(
            factory,
            pipelines,
            sources,
            pixel.kernel,
            pixel.images,
            pixel.tables,
        );
        let format = texture_format(pixel.format);
        let stage = match pixel.pass {
            PixelPass::Draw => ShaderStages::FRAGMENT,
            PixelPass::Compute => {
                let slot = Slot::Stored {
                    format,
                    layered: false,
                };
                seen.push((slot, Bound::View(self.image[0].whole.clone())));
                ShaderStages::COMPUTE
            }
        };
        let layouts = &mut pipelines.layouts;
        let seen_layout = self
            .gbuffer
            .bind(factory, layouts, stage, "umbrage receivers", seen);
        // Build the pipeline.
        let gbuffer_group = options.gbuffer_group();
        let text = kernel_wgsl(pixel.kernel, &shape, options.kernel_group);
        let text = shader(&text, gbuffer_group);
        let mut groups = vec![None; options.kernel_group.max(1) as usize + 1];
        groups[options.kernel_group as usize] = self.kernel.binding.layout();
        groups[gbuffer_group as usize] = Some(&seen_layout);
        let PixelKernel { label, entry, .. } = pixel;
        self.pipeline = Some(match pixel.pass {
            PixelPass::Draw => {
                let pipeline = pipelines.kernel(factory, label, text, entry, format, &groups);
                PixelPipeline::Draw(pipeline)
            }
            PixelPass::Compute => {
                let pipeline = pipelines.compute(factory, label, text, entry, &groups);
                PixelPipeline::Compute(pipeline)
            }
        });
    }

    /// Records the pass, and returns the image; `None` if there is no such stage.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        options: RendererOptions,
        timestamp_writes: Option<RenderPassTimestampWrites<'_>>,
    ) -> Option<&GpuImage> {
        let image = self.image()?;
        let kernel = self.kernel.binding.group();
        let gbuffer = self.gbuffer.group();
        let pipeline = match self.pipeline.as_ref()? {
            PixelPipeline::Draw(pipeline) => pipeline,
            PixelPipeline::Compute(pipeline) => {
                let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                    label: Some(image.desc.label),
                    timestamp_writes: timestamp_writes.map(of_compute),
                });
                pass.set_pipeline(pipeline);
                pass.set_bind_group(options.kernel_group, kernel, &[]);
                pass.set_bind_group(options.gbuffer_group(), gbuffer, &[]);
                let [columns, rows] = pixel_groups(image.desc.size);
                pass.dispatch_workgroups(columns, rows, 1);
                drop(pass);
                return Some(image);
            }
        };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some(image.desc.label),
            color_attachments: &[Some(color_attachment(&image.whole, self.background))],
            timestamp_writes,
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(options.kernel_group, kernel, &[]);
        pass.set_bind_group(options.gbuffer_group(), gbuffer, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        Some(image)
    }

    /// Returns the image that the stage writes.
    pub(crate) fn image(&self) -> Option<&GpuImage> {
        self.image.first()
    }

    /// Returns the bind group of the kernel; `None` before anything is prepared.
    pub(crate) fn kernel_group(&self) -> Option<(&BindGroup, &BindGroupLayout)> {
        let binding = &self.kernel.binding;
        binding.group().zip(binding.layout())
    }
}

/// Returns the number of workgroups of 8 x 8 invocations along each axis, at least one invocation a
/// pixel. pixel_block.wgsl needs a multiple of 8 along y.
pub(crate) fn pixel_groups(size: UVec2) -> [u32; 2] {
    [size.x.div_ceil(8), size.y.div_ceil(8).next_multiple_of(8)]
}

/// Returns the G-buffer's bindings: positions, normals, and triangle ids if there are any.
pub(crate) fn gbuffer_entries(receivers: &GBuffer<'_>) -> Vec<(Slot, Bound)> {
    let floats = Slot::Floats { layered: false };
    let mut entries = vec![
        (floats, Bound::View(receivers.position.clone())),
        (floats, Bound::View(receivers.normal.clone())),
    ];
    if let Some(triangle) = receivers.triangle {
        let whole = Slot::Whole { layered: false };
        entries.push((whole, Bound::View(triangle.clone())));
    }
    entries
}
