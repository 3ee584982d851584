//! Radix sort of 32-bit keys with 32-bit values, least significant digits first, and prefix sums.

use crate::device::{Device, Dispatch, Program};
use anyhow::Result;
use umbrage::gpu::wgpu::Buffer;

/// Number of items that a workgroup sorts: `BLOCK` in sort.wgsl.
const BLOCK: u32 = 2048;
/// Number of digits: `DIGITS` in sort.wgsl.
const DIGITS: u32 = 256;
/// Number of passes.
const PASSES: u32 = 4;
/// Bytes that a pass reads and writes per item: keys to count, then keys and values both ways.
const BYTES_A_PASS: f64 = 4.0 + 8.0 + 8.0;
/// Bytes that the passes read and write per item.
pub(crate) const SORT_BYTES: f64 = PASSES as f64 * BYTES_A_PASS;

/// Pipelines of prefix sums.
pub(crate) struct Scan {
    program: Program,
}

/// Buffers of prefix sums over a buffer's first words.
pub(crate) struct ScanBuffers {
    place: Buffer,
    sums: Buffer,
    blocks: u32,
}

impl Scan {
    pub(crate) fn new(device: &Device) -> Self {
        let wgsl = include_str!("../shaders/scan.wgsl");
        let entries = ["sum_blocks", "sum_all", "place_all"];
        Self {
            program: device.program("scan", wgsl, &entries, &[]),
        }
    }

    /// Returns the buffers for sums over this number of words.
    pub(crate) fn buffers(device: &Device, words: u32) -> ScanBuffers {
        let blocks = words.div_ceil(1024).max(1);
        ScanBuffers {
            place: device.uniform("scan", bytemuck::cast_slice(&[words, blocks, 0, 0])),
            sums: device.zeros("sums", 4 * u64::from(blocks + 1)),
            blocks,
        }
    }

    /// Replaces each word by the sum of the words before it. The total is written to the last word
    /// of `sums`.
    pub(crate) fn record<'a>(
        &'a self,
        device: &Device,
        buffers: &ScanBuffers,
        words: &Buffer,
        out: &mut Vec<Dispatch<'a>>,
    ) -> Result<()> {
        let named = [
            ("scan", &buffers.place),
            ("words", words),
            ("block_sums", &buffers.sums),
        ];
        for (entry, groups) in [
            ("sum_blocks", buffers.blocks),
            ("sum_all", 1),
            ("place_all", buffers.blocks),
        ] {
            out.push(device.dispatch(&self.program, entry, &named, groups)?);
        }
        Ok(())
    }
}

impl ScanBuffers {
    /// Returns the sum of all words.
    pub(crate) fn total(&self, device: &Device) -> Result<u32> {
        Ok(device.read(&self.sums)?[self.blocks as usize])
    }
}

/// Pipelines of the sort.
pub(crate) struct Sort {
    program: Program,
    scan: Scan,
}

/// Buffers to sort up to a number of items.
pub(crate) struct SortBuffers {
    pub(crate) keys: [Buffer; 2],
    pub(crate) values: [Buffer; 2],
    counts: Buffer,
    scan: ScanBuffers,
    passes: Vec<Buffer>,
    blocks: u32,
}

impl SortBuffers {
    pub(crate) fn new(device: &Device, capacity: u32) -> Self {
        let blocks = capacity.div_ceil(BLOCK).max(1);
        let words = || device.zeros("sorted", 4 * u64::from(capacity));
        let pass =
            |pass: u32| device.uniform("pass", bytemuck::cast_slice(&[8 * pass, blocks, 0, 0]));
        Self {
            keys: [words(), words()],
            values: [words(), words()],
            counts: device.zeros("digits", 4 * u64::from(DIGITS * blocks)),
            scan: Scan::buffers(device, DIGITS * blocks),
            passes: (0..PASSES).map(pass).collect(),
            blocks,
        }
    }
}

impl Sort {
    pub(crate) fn new(device: &Device) -> Self {
        let wgsl = include_str!("../shaders/sort.wgsl");
        Self {
            program: device.program("sort", wgsl, &["count_digits", "move_items"], &[]),
            scan: Scan::new(device),
        }
    }

    /// Sorts the first keys and values. `head`'s first word is the number of items.
    pub(crate) fn record<'a>(
        &'a self,
        device: &Device,
        buffers: &SortBuffers,
        head: &Buffer,
        out: &mut Vec<Dispatch<'a>>,
    ) -> Result<()> {
        for (i, pass) in buffers.passes.iter().enumerate() {
            let (from, to) = (i % 2, 1 - i % 2);
            let named = [
                ("digit_pass", pass),
                ("head", head),
                ("keys", &buffers.keys[from]),
                ("values", &buffers.values[from]),
                ("sorted_keys", &buffers.keys[to]),
                ("sorted_values", &buffers.values[to]),
                ("counts", &buffers.counts),
            ];
            out.push(device.dispatch(&self.program, "count_digits", &named, buffers.blocks)?);
            self.scan
                .record(device, &buffers.scan, &buffers.counts, out)?;
            out.push(device.dispatch(&self.program, "move_items", &named, buffers.blocks)?);
        }
        Ok(())
    }
}
