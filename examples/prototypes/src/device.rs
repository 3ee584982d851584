//! A device, compute programs whose bindings are found by name, and passes of dispatches.

use anyhow::{Context as _, Result};
use std::{
    collections::HashMap,
    time::{Duration, Instant},
};
use umbrage::gpu::wgpu::{self, util::DeviceExt as _};

/// Number of invocations of a workgroup of most entry points.
pub(crate) const GROUP: u32 = 64;
/// Number of workgroups in a row of a dispatch: `GROUPS_A_ROW` in WGSL.
const GROUPS_A_ROW: u32 = 32_768;

/// A device for the program alone.
pub(crate) struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Name of the adapter.
    pub(crate) name: String,
}

/// Compute pipelines of one shader module. They share the layout of their bindings.
pub(crate) struct Program {
    label: &'static str,
    layout: wgpu::BindGroupLayout,
    /// Binding number and variable name of each resource.
    slots: Vec<(u32, String)>,
    pipelines: HashMap<&'static str, wgpu::ComputePipeline>,
}

/// A pipeline's dispatch.
pub(crate) struct Dispatch<'a> {
    pub(crate) pipeline: &'a wgpu::ComputePipeline,
    pub(crate) group: wgpu::BindGroup,
    /// Numbers of workgroups, in a row and rows.
    pub(crate) groups: [u32; 2],
}

impl Device {
    /// Opens the default adapter with the adapter's limits.
    pub(crate) fn open() -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .context("no graphics adapter: install a Vulkan driver")?;
        let desc = wgpu::DeviceDescriptor {
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&desc))?;
        let name = adapter.get_info().name;
        Ok(Self {
            device,
            queue,
            name,
        })
    }

    /// Returns a storage buffer of zeros.
    pub(crate) fn zeros(&self, label: &str, bytes: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16).next_multiple_of(16),
            usage,
            mapped_at_creation: false,
        })
    }

    /// Returns a storage buffer with these contents.
    pub(crate) fn storage(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.with_contents(label, contents, wgpu::BufferUsages::STORAGE)
    }

    /// Returns a uniform buffer with these contents.
    pub(crate) fn uniform(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.with_contents(label, contents, wgpu::BufferUsages::UNIFORM)
    }

    fn with_contents(
        &self,
        label: &str,
        contents: &[u8],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        // A binding has at least one element.
        let contents = if contents.is_empty() {
            &[0; 64]
        } else {
            contents
        };
        let desc = wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage: usage | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        };
        self.device.create_buffer_init(&desc)
    }

    /// Compiles the entry points of a module. `constants` are pipeline constants.
    pub(crate) fn program(
        &self,
        label: &'static str,
        wgsl: &str,
        entries: &[&'static str],
        constants: &[(&str, f64)],
    ) -> Program {
        let (slots, types) = bindings_of(wgsl);
        let layout_entries: Vec<_> = slots
            .iter()
            .zip(types)
            .map(|(&(binding, _), ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let desc = wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &layout_entries,
        };
        let layout = self.device.create_bind_group_layout(&desc);
        let module = self
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            });
        let pipeline_layout = self
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &[Some(&layout)],
                ..wgpu::PipelineLayoutDescriptor::default()
            });
        let compile = |&entry: &&'static str| {
            let desc = wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            };
            (entry, self.device.create_compute_pipeline(&desc))
        };
        Program {
            label,
            layout,
            slots,
            pipelines: entries.iter().map(compile).collect(),
        }
    }

    /// Returns a dispatch of an entry point with buffers by the names of their variables. Buffers
    /// that the module doesn't declare are ignored.
    pub(crate) fn dispatch<'a>(
        &self,
        program: &'a Program,
        entry: &str,
        buffers: &[(&str, &wgpu::Buffer)],
        groups: u32,
    ) -> Result<Dispatch<'a>> {
        let mut entries = Vec::new();
        for (binding, name) in &program.slots {
            let found = buffers.iter().find(|(known, _)| known == name);
            let (_, buffer) =
                found.with_context(|| format!("{}: `{name}` has no buffer", program.label))?;
            entries.push(wgpu::BindGroupEntry {
                binding: *binding,
                resource: buffer.as_entire_binding(),
            });
        }
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(program.label),
            layout: &program.layout,
            entries: &entries,
        });
        let pipeline = program.pipelines.get(entry);
        Ok(Dispatch {
            pipeline: pipeline.with_context(|| format!("no entry point `{entry}`"))?,
            group,
            groups: [
                groups.clamp(1, GROUPS_A_ROW),
                groups.div_ceil(GROUPS_A_ROW).max(1),
            ],
        })
    }

    /// Clears buffers, runs dispatches in order, and waits. Returns the time from submission to
    /// completion.
    pub(crate) fn run(
        &self,
        cleared: &[&wgpu::Buffer],
        dispatches: &[Dispatch<'_>],
    ) -> Result<Duration> {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for buffer in cleared {
            encoder.clear_buffer(buffer, 0, None);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for dispatch in dispatches {
            pass.set_pipeline(dispatch.pipeline);
            pass.set_bind_group(0, &dispatch.group, &[]);
            pass.dispatch_workgroups(dispatch.groups[0], dispatch.groups[1], 1);
        }
        drop(pass);
        self.wait()?;
        let start = Instant::now();
        self.queue.submit([encoder.finish()]);
        self.wait()?;
        Ok(start.elapsed())
    }

    fn wait(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }

    /// Returns a buffer's words.
    pub(crate) fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u32>> {
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        copy.map_async(wgpu::MapMode::Read, .., |_| {});
        self.wait()?;
        let bytes = copy.get_mapped_range(..)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

/// Finds the bindings that a module declares, one a line: `@group(0) @binding(1) var<..> name: ..`.
fn bindings_of(wgsl: &str) -> (Vec<(u32, String)>, Vec<wgpu::BufferBindingType>) {
    let mut slots = Vec::new();
    let mut types = Vec::new();
    for line in wgsl.lines() {
        let Some(rest) = line.strip_prefix("@group(0) @binding(") else {
            continue;
        };
        let Some((number, rest)) = rest.split_once(") var<") else {
            continue;
        };
        let Some((space, rest)) = rest.split_once("> ") else {
            continue;
        };
        let Some((name, _)) = rest.split_once(':') else {
            continue;
        };
        slots.push((number.parse().unwrap_or(u32::MAX), name.to_owned()));
        types.push(match space {
            "uniform" => wgpu::BufferBindingType::Uniform,
            space => wgpu::BufferBindingType::Storage {
                read_only: space == "storage, read",
            },
        });
    }
    (slots, types)
}
