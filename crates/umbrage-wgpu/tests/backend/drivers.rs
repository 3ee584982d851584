//! Checks that the pinned driver still needs each workaround.

use crate::scene::gpu;
use std::ops::RangeInclusive;
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use umbrage_wgpu::{
    Gpu, SHORT_LOOPS, STEADY_FIRST_WORD, SUM_ORDER, Workaround,
    wgpu::{
        BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, BufferDescriptor, BufferUsages,
        CommandEncoderDescriptor, Extent3d, FragmentState, MapMode, MultisampleState, Operations,
        PipelineCompilationOptions, PollType, PrimitiveState, RenderPassColorAttachment,
        RenderPassDescriptor, RenderPipeline, RenderPipelineDescriptor, ShaderModuleDescriptor,
        ShaderSource, TexelCopyBufferInfo, TexelCopyBufferLayout, Texture, TextureDescriptor,
        TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor, VertexState,
    },
};

/// A fragment shader that reads the words `given` and returns one word.
struct Drawing<'a> {
    gpu: &'a Gpu,
    pipeline: RenderPipeline,
    group: BindGroup,
    given: Buffer,
    image: Texture,
    back: Buffer,
}

impl<'a> Drawing<'a> {
    /// Builds the drawing; `body` is that of the fragment shader.
    fn new(gpu: &'a Gpu, body: &str) -> Self {
        let (device, _) = gpu.device();
        let text = format!(
            "struct Given {{ first: u32, second: u32, third: u32, fourth: u32, floats: vec4f }}
@group(0) @binding(0) var<uniform> given: Given;
@vertex fn place(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {{
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.0, 1.0);
}}
@fragment fn run() -> @location(0) u32 {{
{body}
}}
"
        );
        let module = &device.create_shader_module(ShaderModuleDescriptor {
            label: None,
            source: ShaderSource::Wgsl(text.into()),
        });
        let format = TextureFormat::R32Uint;
        let pipeline = device.create_render_pipeline(&RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: VertexState {
                module,
                entry_point: Some("place"),
                compilation_options: PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: PrimitiveState::default(),
            depth_stencil: None,
            multisample: MultisampleState::default(),
            fragment: Some(FragmentState {
                module,
                entry_point: Some("run"),
                compilation_options: PipelineCompilationOptions::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let buffer = |usage, size| {
            device.create_buffer(&BufferDescriptor {
                label: None,
                size,
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let given = buffer(BufferUsages::UNIFORM, 32);
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[BindGroupEntry {
                binding: 0,
                resource: given.as_entire_binding(),
            }],
        });
        let image = device.create_texture(&TextureDescriptor {
            label: None,
            size: Extent3d::default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Self {
            gpu,
            pipeline,
            group,
            given,
            image,
            back: buffer(BufferUsages::MAP_READ, 4),
        }
    }

    /// Returns the word that the shader returns.
    fn run(&self, given: [u32; 8]) -> u32 {
        let (device, queue) = self.gpu.device();
        queue.write_buffer(&self.given, 0, bytemuck::cast_slice(&given));
        let view = self.image.create_view(&TextureViewDescriptor::default());
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations::default(),
            })],
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        let to = TexelCopyBufferInfo {
            buffer: &self.back,
            layout: TexelCopyBufferLayout::default(),
        };
        encoder.copy_texture_to_buffer(self.image.as_image_copy(), to, self.image.size());
        queue.submit([encoder.finish()]);
        let back = &self.back;
        back.map_async(MapMode::Read, .., |mapped| mapped.expect("readable"));
        let waited = device.poll(PollType::wait_indefinitely());
        waited.expect("the device works");
        let bytes = back.get_mapped_range(..).expect("is mapped");
        let word = u32::from_le_bytes(*bytes.first_chunk().expect("a word"));
        drop(bytes);
        back.unmap();
        word
    }
}

/// Asserts that a driver has the symptom of a workaround, if it is the pinned driver.
fn assert_needed(gpu: &Gpu, workaround: &Workaround, has_symptom: bool, seen: &str) {
    if !gpu.promises_bits() {
        return;
    }
    let Workaround {
        driver,
        symptom,
        rule,
    } = workaround;
    assert!(
        has_symptom,
        "{driver} no longer {symptom} ({seen}): remove the workaround, and the rule that {rule}"
    );
}

#[test]
fn loops_end_early() {
    let gpu = gpu();
    let drawing = Drawing::new(
        &gpu,
        "    var turns = 0u;
    for (var i = 0u; i < given.first; i++) {
        turns += given.second;
    }
    return turns;",
    );
    let turns = |turns| drawing.run([turns, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(turns(1_000), 1_000, "the drawing counts");
    let found = turns(70_000);
    let seen = format!("{found} turns of 70,000");
    assert_needed(&gpu, &SHORT_LOOPS, found < 70_000, &seen);
}

#[test]
fn sums_are_reordered() {
    let gpu = gpu();
    let drawing = Drawing::new(
        &gpu,
        "    let a = bitcast<f32>(given.first);
    let factors = given.floats;
    return bitcast<u32>(a + (factors.x * factors.y + factors.z * factors.w));",
    );
    let one = 1.0_f32.to_bits();
    let sum = |a: f32| {
        let given = [a.to_bits(), 0, 0, 0, one, one, one, one];
        f32::from_bits(drawing.run(given))
    };
    assert_eq!(sum(3.0), 5.0, "the drawing adds");
    // Added from left to right, each 1 is lost: floats of this size are even.
    let large = 16_777_216.0;
    let found = sum(large);
    assert_needed(&gpu, &SUM_ORDER, found == large, &format!("{found}"));
}

#[test]
fn the_first_word_of_uniforms_is_compiled_in() {
    let gpu = gpu();
    // Use enough text that compilation takes much longer than execution. Use a different text each
    // time, since the driver caches compiled shaders on disk.
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let salt = now.map_or(0, |now| now.subsec_nanos());
    let mut body = "    var x = given.floats.x;\n".to_owned();
    // Each value has its own code.
    for value in [1, 2] {
        body += &format!("    if given.first == {value}u {{\n");
        for i in 0..40 {
            body += &format!("        x = sin(x) * {value}{i}.{salt} + sqrt(abs(x));\n");
        }
        body += "    }\n";
    }
    body += "    return bitcast<u32>(x);";
    let drawing = Drawing::new(&gpu, &body);
    // Take the shortest run, as other programs may use the processor.
    let shortest = |word: usize, values: RangeInclusive<u32>| {
        let elapsed = values.map(|value| {
            let mut given = [0; 8];
            given[word] = value;
            let start = Instant::now();
            drawing.run(given);
            start.elapsed()
        });
        elapsed.min().unwrap_or_default()
    };
    drawing.run([0; 8]);
    // For further values of the first word the driver uses one shader for all.
    let first = shortest(0, 1..=2);
    let second = shortest(1, 1..=8);
    let seen = format!("{first:?} for a new first word, {second:?} for a new second one");
    assert_needed(&gpu, &STEADY_FIRST_WORD, first > 5 * second, &seen);
}
