//! One compute pass from words to words.

use crate::adapter::TestDevice;
use wgpu::util::DeviceExt as _;

/// Runs the wrapper's entry point once for each of `count` inputs.
pub(super) fn run(
    on: &TestDevice,
    wgsl: &str,
    inputs: &[u32],
    outputs: usize,
    count: usize,
) -> Result<Vec<u32>, String> {
    let scope = on.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = on
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("twin"),
            source: wgpu::ShaderSource::Wgsl(wgsl.into()),
        });
    let pipeline = on
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("twin"),
            layout: None,
            module: &module,
            entry_point: Some("twin_main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(error.to_string()),
        None => Ok(dispatch(on, &pipeline, inputs, outputs, count)),
    }
}

fn dispatch(
    on: &TestDevice,
    pipeline: &wgpu::ComputePipeline,
    inputs: &[u32],
    outputs: usize,
    count: usize,
) -> Vec<u32> {
    // The last word is a 0 that is unknown to the compiler.
    let words = [inputs, &[0]].concat();
    let input = on
        .device
        .create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("twin inputs"),
            contents: bytemuck::cast_slice(&words),
            usage: wgpu::BufferUsages::STORAGE,
        });
    // Create the output, and a buffer for reading it back.
    let buffer = |label, usage| {
        let size = 4 * outputs as u64;
        on.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let output = buffer(
        "twin outputs",
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    );
    let back = buffer(
        "twin outputs, read back",
        wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
    );
    let group = on.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("twin"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: input.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: output.as_entire_binding(),
            },
        ],
    });
    // Run the wrapper, and read its output.
    let mut encoder = on
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(count as u32 / 64, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &back, 0, None);
    on.queue.submit([encoder.finish()]);
    read(on, &back)
}

fn read(on: &TestDevice, buffer: &wgpu::Buffer) -> Vec<u32> {
    buffer.map_async(wgpu::MapMode::Read, .., |result| {
        result.expect("the buffer is mappable and not in use")
    });
    on.device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device answers");
    let view = buffer.get_mapped_range(..).expect("the buffer is mapped");
    bytemuck::cast_slice(&view).to_vec()
}
