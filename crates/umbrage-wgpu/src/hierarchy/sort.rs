//! Radix sort of the numbers of items by 32-bit keys on the device, least significant digits first
//! (`sort.wgsl`).

use crate::{
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::Pipelines,
        windows::Windows,
    },
    wgsl::stages::shader_of,
};
use std::num::NonZeroU64;
use wgpu::{Buffer, BufferUsages, ComputePass, ComputePipeline, ShaderStages};

/// Number of items per workgroup: `BLOCK` in sort.wgsl.
const BLOCK: u32 = 2048;
/// Number of digits: `DIGITS` in sort.wgsl.
const DIGITS: u32 = 256;
/// Number of counts per workgroup of prefix sums: `SUM_BLOCK` in sort.wgsl.
const SUM_BLOCK: u32 = 1024;
/// Number of passes, one per digit of 8 bits. It is even, so the result is in the first buffers.
/// `LAST_SHIFT` in sort.wgsl is the shift of the last one.
const PASSES: u32 = 4;
/// The shaders of a pass, and whether a workgroup handles a block of items, a block of counts, or
/// all counts.
const SHADERS: [(&str, Groups); 5] = [
    ("count_digits", Groups::Items),
    ("sum_counts", Groups::Counts),
    ("sum_all", Groups::One),
    ("place_counts", Groups::Counts),
    ("move_items", Groups::Items),
];
/// Bytes of `SortPass` in sort.wgsl.
const PASS: NonZeroU64 = NonZeroU64::new(20).unwrap();

/// Greatest number of items: those of a dispatch along one axis.
pub(crate) const MOST_ITEMS: u64 = 65_535 * BLOCK as u64;

/// Unit of a shader's workgroups.
#[derive(Clone, Copy, Debug)]
enum Groups {
    Items,
    Counts,
    One,
}

/// Items to sort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SortRange {
    /// Number of items that are not counted by the first word of the items' head.
    pub(crate) first: u32,
    /// Greatest number of items.
    pub(crate) most: u32,
}

impl SortRange {
    fn blocks(self) -> u32 {
        self.most.div_ceil(BLOCK).max(1)
    }

    fn sum_blocks(self) -> u32 {
        (DIGITS * self.blocks()).div_ceil(SUM_BLOCK)
    }
}

/// Buffers of the items. Keys and numbers have two copies. The first keys are the input, and the
/// first numbers the result.
#[derive(Debug)]
pub(crate) struct SortBuffers {
    /// The first word counts items.
    pub(crate) head: Buffer,
    pub(crate) keys: [Buffer; 2],
    pub(crate) numbers: [Buffer; 2],
    counts: Buffer,
    sums: Buffer,
}

impl SortBuffers {
    /// Creates buffers for ranges of up to `most` items. `head` is the number of words of their
    /// head.
    pub(crate) fn new(factory: &mut ResourceFactory<'_>, most: u32, head: u64) -> Self {
        let range = SortRange { first: 0, most };
        let mut buffer =
            |label: &str, words: u64| factory.buffer(label, BufferUsages::STORAGE, 4 * words);
        let items = u64::from(most).max(1);
        Self {
            head: buffer("umbrage sort head", head),
            keys: [0; 2].map(|_| buffer("umbrage keys", items)),
            numbers: [0; 2].map(|_| buffer("umbrage numbers", items)),
            counts: buffer("umbrage digits", u64::from(DIGITS * range.blocks())),
            sums: buffer("umbrage sums", u64::from(range.sum_blocks())),
        }
    }

    /// Returns all buffers.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Buffer> {
        let items = self.keys.iter().chain(&self.numbers);
        items.chain([&self.head, &self.counts, &self.sums])
    }
}

/// Sorts several ranges of the same buffers, one after another.
#[derive(Debug, Default)]
pub(crate) struct SortStage {
    pipelines: Vec<ComputePipeline>,
    passes: Windows,
    /// Passes from the first copies to the second ones, and back.
    bindings: [Binding; 2],
}

impl SortStage {
    /// Drops the bind groups, and with them the buffers that only they keep.
    pub(crate) fn drop_bindings(&mut self) {
        self.bindings = Default::default();
    }

    /// Writes the inputs of the passes that sort these ranges.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        buffers: &SortBuffers,
        ranges: impl Iterator<Item = SortRange>,
    ) {
        let passes = ranges.flat_map(|range| {
            (0..PASSES).map(move |pass| {
                let shift = 8 * pass;
                let blocks = [range.blocks(), range.sum_blocks()];
                [shift, blocks[0], blocks[1], range.first, range.most]
            })
        });
        let Some((passes, _)) = self.passes.write(factory, "umbrage sort", passes) else {
            return;
        };
        // Create the pipelines on first use.
        let slots = [
            Slot::Window(PASS),
            Slot::Table,
            Slot::Table,
            Slot::Table,
            Slot::Written,
            Slot::Written,
            Slot::Written,
            Slot::Written,
        ];
        let stages = ShaderStages::COMPUTE;
        let layout = pipelines.layouts.get(factory, stages, &slots);
        if self.pipelines.is_empty() {
            let text = shader_of(&["sort"]);
            let groups = [Some(&layout)];
            let entries = SHADERS.map(|(entry, _)| entry);
            self.pipelines = pipelines.computes(factory, "umbrage sort", text, &entries, &groups);
        }
        // Bind the buffers. Each pass moves the items to the other copy.
        for (from, binding) in self.bindings.iter_mut().enumerate() {
            let to = 1 - from;
            let SortBuffers { head, counts, .. } = buffers;
            let all = [
                head,
                &buffers.keys[from],
                &buffers.numbers[from],
                &buffers.keys[to],
                &buffers.numbers[to],
                counts,
                &buffers.sums,
            ];
            let mut bound = vec![Bound::Window(passes.clone(), PASS)];
            bound.extend(all.map(|buffer| Bound::Buffer(buffer.clone())));
            binding.set(factory, "umbrage sort", &layout, bound);
        }
    }

    /// Records the passes that sort a range, by its number among the prepared ones.
    pub(crate) fn encode(&self, pass: &mut ComputePass<'_>, number: usize, range: SortRange) {
        for digit in 0..PASSES as usize {
            let offset = self.passes.offset(PASSES as usize * number + digit);
            pass.set_bind_group(0, self.bindings[digit % 2].group(), &[offset]);
            for (pipeline, (_, groups)) in self.pipelines.iter().zip(SHADERS) {
                let groups = match groups {
                    Groups::Items => range.blocks(),
                    Groups::Counts => range.sum_blocks(),
                    Groups::One => 1,
                };
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(groups, 1, 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{
        BLOCK, Buffer, BufferUsages, DIGITS, PASSES, SUM_BLOCK, SortBuffers, SortRange, SortStage,
    };
    use crate::{
        AdapterChoice, Gpu,
        device::readback::{ReadBack, Spare},
        resources::{
            counters::{Counters, ResourceFactory},
            pipelines::Pipelines,
        },
        wgsl::stages::shader_of,
    };
    use umbrage_core::light_sample::hash;

    #[test]
    fn constants_are_those_of_the_shader() {
        let text = shader_of(&["sort"]);
        for (name, value) in [
            ("BLOCK", BLOCK),
            ("DIGITS", DIGITS),
            ("SUM_BLOCK", SUM_BLOCK),
            ("LAST_SHIFT", 8 * (PASSES - 1)),
        ] {
            let line = format!("const {name} = {value}u;");
            assert!(text.contains(&line), "{line}");
        }
    }

    /// Content of places that the sort doesn't write.
    const NO_ITEM: u32 = u32::MAX;

    /// Returns the numbers of at most `most` keys in sorted order, then [`NO_ITEM`] for the others.
    /// The head counts `more` of the keys.
    fn sort(gpu: &Gpu, keys: &[u32], more: u32, most: u32) -> Vec<u32> {
        let (device, queue) = gpu.device();
        let mut counters = Counters::default();
        let mut factory = ResourceFactory::new(device, queue, &mut counters);
        // Create buffers that can be read back.
        let mut buffers = SortBuffers::new(&mut factory, most, 1);
        let mut readable = |words: &[u32]| -> Buffer {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            let buffer = factory.buffer("items", usage, 4 * words.len() as u64);
            factory
                .queue
                .write_buffer(&buffer, 0, bytemuck::cast_slice(words));
            buffer
        };
        buffers.keys[0] = readable(keys);
        buffers.numbers[0] = readable(&vec![NO_ITEM; keys.len()]);
        buffers.head = readable(&[more]);
        // Sort.
        let range = SortRange {
            first: keys.len() as u32 - more,
            most,
        };
        let mut stage = SortStage::default();
        let mut pipelines = Pipelines::default();
        stage.prepare(&mut factory, &mut pipelines, &buffers, [range].into_iter());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        stage.encode(&mut pass, 0, range);
        drop(pass);
        // Read the numbers back.
        let mut spare = Spare::default();
        let mut back = ReadBack::new(device, &mut counters, &mut spare);
        let ticket = back.buffer(&mut encoder, &buffers.numbers[0]);
        queue.submit([encoder.finish()]);
        back.wait().expect("reads");
        back.read(ticket).expect("reads")
    }

    /// Returns whether numbers are those of sorted keys, with equal keys in their order.
    fn is_sorted(keys: &[u32], found: &[u32]) -> bool {
        let mut expected: Vec<u32> = (0..keys.len() as u32).collect();
        expected.sort_by_key(|&number| keys[number as usize]);
        found == expected
    }

    #[test]
    fn items_are_sorted_and_equal_ones_keep_their_order() {
        let gpu = Gpu::new(&AdapterChoice::from_env()).expect("an adapter");
        // Blocks of items and of counts are full, or have one item more or less.
        for count in [1, 255, 256, 2047, 2048, 2049, 8192, 8193, 100_000] {
            for bits in [32, 9, 1] {
                let key = |i: u32| hash(i ^ (bits << 20)) >> (32 - bits);
                let keys: Vec<u32> = (0..count).map(key).collect();
                let found = sort(&gpu, &keys, count / 3, count + 5000);
                assert!(is_sorted(&keys, &found), "{count} items of {bits} bits");
            }
        }
        // Items beyond the capacity are left out.
        let keys: Vec<u32> = (0..5000).rev().collect();
        let found = sort(&gpu, &keys, 1000, 3000);
        assert!(is_sorted(&keys[..3000], &found[..3000]));
        assert!(found[3000..].iter().all(|&number| number == NO_ITEM));
        // The comparison notices two exchanged items of equal keys.
        let keys = [7; 100];
        let mut found = sort(&gpu, &keys, 0, 100);
        assert!(is_sorted(&keys, &found));
        found.swap(3, 4);
        assert!(!is_sorted(&keys, &found));
    }
}
