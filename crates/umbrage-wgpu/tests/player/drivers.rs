//! The pinned driver still needs each workaround.

use crate::scene::gpu;
use std::time::{Duration, Instant};
use umbrage_wgpu::{
    Gpu, SHORT_LOOPS, STEADY_FIRST_WORD, SUM_ORDER, Workaround,
    wgpu::{
        BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, BufferUsages,
        CommandEncoderDescriptor, ComputePassDescriptor, ComputePipeline,
        ComputePipelineDescriptor, MapMode, PollType, ShaderModuleDescriptor, ShaderSource,
        util::{BufferInitDescriptor, DeviceExt},
    },
};

/// A compute shader that reads the words `given` and writes `found`.
struct Program<'a> {
    gpu: &'a Gpu,
    pipeline: ComputePipeline,
    group: BindGroup,
    given: Buffer,
    found: Buffer,
    back: Buffer,
}

impl<'a> Program<'a> {
    /// `body` is that of the entry point.
    fn new(gpu: &'a Gpu, body: &str) -> Self {
        let (device, _) = gpu.device();
        let text = format!(
            "@group(0) @binding(0) var<uniform> given: array<vec4u, 2>;
@group(0) @binding(1) var<storage, read_write> found: array<u32, 4>;
@compute @workgroup_size(1) fn run() {{
{body}
}}
"
        );
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: None,
            source: ShaderSource::Wgsl(text.into()),
        });
        let pipeline = device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("run"),
            compilation_options: Default::default(),
            cache: None,
        });
        let buffer = |usage, bytes: usize| {
            device.create_buffer_init(&BufferInitDescriptor {
                label: None,
                contents: &vec![0; bytes],
                usage,
            })
        };
        let given = buffer(BufferUsages::UNIFORM | BufferUsages::COPY_DST, 32);
        let found = buffer(BufferUsages::STORAGE | BufferUsages::COPY_SRC, 16);
        let back = buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST, 16);
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                BindGroupEntry {
                    binding: 0,
                    resource: given.as_entire_binding(),
                },
                BindGroupEntry {
                    binding: 1,
                    resource: found.as_entire_binding(),
                },
            ],
        });
        Self {
            gpu,
            pipeline,
            group,
            given,
            found,
            back,
        }
    }

    /// Returns the first word that the shader finds.
    fn run(&self, given: [u32; 8]) -> u32 {
        let (device, queue) = self.gpu.device();
        queue.write_buffer(&self.given, 0, bytemuck::cast_slice(&given));
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&self.found, 0, &self.back, 0, 16);
        queue.submit([encoder.finish()]);
        self.back
            .map_async(MapMode::Read, .., |mapped| mapped.expect("readable"));
        device
            .poll(PollType::wait_indefinitely())
            .expect("the device works");
        let bytes = self.back.get_mapped_range(..).expect("is mapped");
        let word = u32::from_le_bytes(*bytes.first_chunk().expect("four words"));
        drop(bytes);
        self.back.unmap();
        word
    }
}

/// Asserts that a driver has the symptom of a workaround, where bits are promised of it.
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
    let program = Program::new(
        &gpu,
        "    var turns = 0u;
    for (var i = 0u; i < given[0].x; i++) {
        turns += given[0].y;
    }
    found[0] = turns;",
    );
    let turns = |turns| program.run([turns, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(turns(1_000), 1_000, "the program counts");
    let found = turns(70_000);
    let seen = format!("{found} turns of 70,000");
    assert_needed(&gpu, &SHORT_LOOPS, found < 70_000, &seen);
}

#[test]
fn sums_are_reordered() {
    let gpu = gpu();
    let program = Program::new(
        &gpu,
        "    let a = bitcast<f32>(given[0].x);
    let factors = bitcast<vec4f>(given[1]);
    found[0] = bitcast<u32>(a + (factors.x * factors.y + factors.z * factors.w));",
    );
    let one = 1.0_f32.to_bits();
    let sum = |a: f32| {
        let given = [a.to_bits(), 0, 0, 0, one, one, one, one];
        f32::from_bits(program.run(given))
    };
    assert_eq!(sum(3.0), 5.0, "the program adds");
    // From left to right, each 1 is lost: floats of this size are even.
    let large = 16_777_216.0;
    let found = sum(large);
    assert_needed(&gpu, &SUM_ORDER, found == large, &format!("{found}"));
}

#[test]
fn the_first_word_of_uniforms_is_compiled_in() {
    let gpu = gpu();
    // Enough text that compiling it takes longer than running it.
    let mut body = "    var x = bitcast<f32>(given[1].x);\n".to_owned();
    for i in 0..200 {
        body += &format!(
            "    if given[0].x == {i}u || given[0].y == {i}u {{ x = sin(x) * {i}.5; }} else {{ x = x * x + sqrt(abs(x)); }}\n"
        );
    }
    body += "    found[0] = bitcast<u32>(x);";
    let program = Program::new(&gpu, &body);
    // The shortest of several: other programs may take the processor.
    let shortest = |word: usize| {
        let mut shortest = Duration::MAX;
        for value in 1..8 {
            let mut given = [0; 8];
            given[word] = 1_000 + value;
            let start = Instant::now();
            program.run(given);
            shortest = shortest.min(start.elapsed());
        }
        shortest
    };
    program.run([0; 8]);
    let first = shortest(0);
    let second = shortest(4);
    let seen = format!("{first:?} for a new first word, {second:?} for another one");
    println!("{seen}");
    assert_needed(&gpu, &STEADY_FIRST_WORD, first > 3 * second, &seen);
}
