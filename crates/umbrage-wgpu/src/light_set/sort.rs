//! Radix sort of 32-bit keys with 32-bit values on the device, least significant digits first
//! (`sort.wgsl`), with prefix sums (`scan.wgsl`).

use crate::{
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::{Pipelines, compute_pipeline, shader},
    },
    wgsl::stages::shader_of,
};
use wgpu::{Buffer, BufferUsages, ComputePass, ComputePipeline, ShaderStages};

/// Number of items per workgroup: `BLOCK` in sort.wgsl.
const BLOCK: u32 = 2048;
/// Number of digits: `DIGITS` in sort.wgsl.
const DIGITS: u32 = 256;
/// Number of words per workgroup of prefix sums: `BLOCK` in scan.wgsl.
const SCAN_BLOCK: u32 = 1024;
/// Number of passes, one per digit of 8 bits. It is even, so the result is in the first buffers.
const PASSES: u32 = 4;

/// Pipelines of the sort, and of prefix sums: blocks, all, places.
#[derive(Debug)]
struct SortPipelines {
    digits: [ComputePipeline; 2],
    scan: [ComputePipeline; 3],
}

/// Sorts up to a number of items.
#[derive(Debug, Default)]
pub(crate) struct SortStage {
    pipelines: Option<SortPipelines>,
    blocks: u32,
    scan_blocks: u32,
    passes: [Binding; PASSES as usize],
    scan: Binding,
}

/// Buffers of the items, each in two copies. The input and the result are in the first ones.
#[derive(Clone, Debug)]
pub(crate) struct SortItems {
    /// The first word is the number of items.
    pub(crate) head: Buffer,
    pub(crate) keys: [Buffer; 2],
    pub(crate) values: [Buffer; 2],
}

impl SortStage {
    /// Returns the bytes of the sort's own largest buffer, for this capacity.
    pub(crate) fn scratch_bytes(capacity: u32) -> u64 {
        4 * u64::from(DIGITS) * u64::from(capacity.div_ceil(BLOCK).max(1))
    }

    /// Creates the buffers and bindings to sort up to `capacity` items.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        items: &SortItems,
        capacity: u32,
    ) {
        // Create the pipelines on first use.
        let stages = ShaderStages::COMPUTE;
        let digit_slots = [
            Slot::Uniform,
            Slot::Table,
            Slot::Table,
            Slot::Table,
            Slot::Written,
            Slot::Written,
            Slot::Written,
        ];
        let scan_slots = [Slot::Uniform, Slot::Written, Slot::Written];
        let digits = pipelines.layouts.get(factory, stages, &digit_slots);
        let scan = pipelines.layouts.get(factory, stages, &scan_slots);
        self.pipelines.get_or_insert_with(|| {
            factory.counters.pipelines += 5;
            let device = factory.device;
            let sort_module = shader(device, "umbrage sort", &shader_of(&["sort"]));
            let scan_module = shader(device, "umbrage scan", &shader_of(&["scan"]));
            let digit = |entry| {
                compute_pipeline(device, &sort_module, entry, &[], &[Some(&digits)])
            };
            let sum = |entry| compute_pipeline(device, &scan_module, entry, &[], &[Some(&scan)]);
            SortPipelines {
                digits: ["count_digits", "move_items"].map(digit),
                scan: ["sum_blocks", "sum_all", "place_all"].map(sum),
            }
        });
        // Create the buffers.
        self.blocks = capacity.div_ceil(BLOCK).max(1);
        let words = DIGITS * self.blocks;
        self.scan_blocks = words.div_ceil(SCAN_BLOCK);
        let storage = BufferUsages::STORAGE;
        let counts = factory.buffer("umbrage digits", storage, 4 * u64::from(words));
        let sums_bytes = 4 * u64::from(self.scan_blocks + 1);
        let sums = factory.buffer("umbrage sums", storage, sums_bytes);
        let mut uniform = |words: [u32; 4]| {
            let bytes: &[u8] = bytemuck::cast_slice(&words);
            let buffer = factory.buffer("umbrage sort pass", BufferUsages::UNIFORM, 16);
            factory.queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let scan_place = uniform([words, self.scan_blocks, 0, 0]);
        let passes = [0, 1, 2, 3].map(|pass| uniform([8 * pass, self.blocks, 0, 0]));
        // Bind them. Each pass moves the items to the other copy.
        for (i, (binding, pass)) in self.passes.iter_mut().zip(passes).enumerate() {
            let (from, to) = (i % 2, 1 - i % 2);
            let all = [
                &pass,
                &items.head,
                &items.keys[from],
                &items.values[from],
                &items.keys[to],
                &items.values[to],
                &counts,
            ];
            let bound = all.map(|buffer| Bound::Buffer(buffer.clone())).to_vec();
            binding.set(factory, "umbrage sort", &digits, bound);
        }
        let all = [&scan_place, &counts, &sums];
        let bound = all.map(|buffer| Bound::Buffer(buffer.clone())).to_vec();
        self.scan.set(factory, "umbrage scan", &scan, bound);
    }

    /// Records the passes.
    pub(crate) fn encode(&self, pass: &mut ComputePass<'_>) {
        let Some(pipelines) = &self.pipelines else {
            return;
        };
        let [count_digits, move_items] = &pipelines.digits;
        let scan_groups = [self.scan_blocks, 1, self.scan_blocks];
        for binding in &self.passes {
            pass.set_bind_group(0, binding.group(), &[]);
            pass.set_pipeline(count_digits);
            pass.dispatch_workgroups(self.blocks, 1, 1);
            // Turn the counts into places.
            pass.set_bind_group(0, self.scan.group(), &[]);
            for (pipeline, groups) in pipelines.scan.iter().zip(scan_groups) {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(groups, 1, 1);
            }
            pass.set_bind_group(0, binding.group(), &[]);
            pass.set_pipeline(move_items);
            pass.dispatch_workgroups(self.blocks, 1, 1);
        }
    }
}
