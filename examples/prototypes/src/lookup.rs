//! The lookup of all receivers, timed without counters, then counted.

use crate::{device::Device, frame::Frame};
use anyhow::Result;
use std::time::Duration;
use umbrage::gpu::wgpu::Buffer;

/// A structure's part of the lookup: `is_shadowed`, and the buffers that it reads.
pub(crate) struct LookUp<'a> {
    pub(crate) wgsl: String,
    pub(crate) buffers: Vec<(&'static str, &'a Buffer)>,
}

/// Answers of a lookup.
pub(crate) struct Answered {
    pub(crate) answers: Vec<u32>,
    pub(crate) counted: Vec<[u32; 2]>,
    pub(crate) time: Duration,
}

/// Answers all receivers.
pub(crate) fn answer(device: &Device, frame: &Frame, look_up: &LookUp<'_>) -> Result<Answered> {
    let pixels = u64::from(frame.pixels());
    let answers = device.zeros("answers", 4 * pixels);
    let counted = device.zeros("counted", 8 * pixels);
    let image = device.uniform(
        "image",
        bytemuck::cast_slice(&[frame.size.x, frame.size.y, 0, 0]),
    );
    // A structure's own buffers replace the frame's.
    let mut named = look_up.buffers.clone();
    named.extend([
        ("kernel", &frame.kernel),
        ("receivers", &frame.receivers),
        ("answers", &answers),
        ("counted", &counted),
        ("image", &image),
        ("table_3", &frame.corners),
        ("table_4", &frame.cut_outs),
    ]);
    let wgsl = format!("{}{}", look_up.wgsl, include_str!("../shaders/lookup.wgsl"));
    let groups = frame.size.x.div_ceil(8) * frame.size.y.div_ceil(8);
    let mut time = Duration::MAX;
    for counts in [0.0, 1.0] {
        let program = device.program("lookup", &wgsl, &["look_up"], &[("COUNTS", counts)]);
        for _ in 0..2 {
            let dispatch = device.dispatch(&program, "look_up", &named, groups)?;
            let elapsed = device.run(&[&answers], &[dispatch])?;
            if counts == 0.0 {
                time = time.min(elapsed);
            } else {
                break;
            }
        }
    }
    let words = device.read(&counted)?;
    Ok(Answered {
        answers: device.read(&answers)?[..pixels as usize].to_vec(),
        counted: words.chunks_exact(2).map(|c| [c[0], c[1]]).collect(),
        time,
    })
}
