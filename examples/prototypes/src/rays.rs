//! Today's rays, for comparison: a binary hierarchy that the CPU builds.

use crate::{
    device::Device,
    frame::Frame,
    lookup::{LookUp, answer},
    outcome::{Made, Outcome},
};
use anyhow::{Context as _, Result, ensure};
use std::time::Duration;
use umbrage::{MATH, join};

/// Bytes of a node, and of a triangle.
const NODE: f64 = 32.0;
const TRIANGLE: f64 = 48.0;

/// Walks the library's hierarchy. Returns `None` if a table exceeds what the device binds.
pub(crate) fn run(device: &Device, frame: &Frame) -> Result<Option<Outcome>> {
    let tables = &frame.rays.tables;
    let most = device.device.limits().max_storage_buffer_binding_size;
    if tables.iter().any(|t| 16 * t.rows().len() as u64 > most) {
        return Ok(None);
    }
    let upload = |i: usize| match tables.get(i) {
        Some(table) => device.storage("table", bytemuck::cast_slice(table.rows())),
        None => device.zeros("table", 16),
    };
    let [nodes, triangles, cut_outs] = [0, 1, 2].map(upload);
    let mut wgsl = join(&[MATH]);
    for module in frame.rays.receive.kernel.modules() {
        let text = match module.name {
            "traced" => {
                let parts = module.text.split_once("fn receive(");
                parts.context("traced.wgsl has no `receive`")?.0
            }
            _ => module.text,
        };
        wgsl += &format!("{text}\n");
    }
    let plain = wgsl.len();
    wgsl = wgsl
        .replacen(
            "let node = stack[top];",
            "let node = stack[top]; walked += 1u;",
            1,
        )
        .replacen(
            "let a = table_1[3u * i];",
            "let a = table_1[3u * i]; tested += 1u;",
            1,
        );
    ensure!(wgsl.len() == plain + 28, "traced.wgsl has changed");
    wgsl += frame.uniforms_wgsl()?;
    wgsl += "fn is_shadowed(o: vec3f, d: vec3f, own: u32) -> bool {\n    return occluded(o, d, own);\n}\n";
    for i in 0..3 {
        let binding = 7 + i;
        wgsl +=
            &format!("@group(0) @binding({binding}) var<storage, read> table_{i}: array<vec4u>;\n");
    }
    let look_up = LookUp {
        wgsl,
        buffers: vec![
            ("table_0", &nodes),
            ("table_1", &triangles),
            ("table_2", &cut_outs),
        ],
    };
    let answered = answer(device, frame, &look_up)?;
    let casters = f64::from(frame.casters.max(1));
    Ok(Some(Outcome {
        candidate: "today's rays, hierarchy of the CPU".to_owned(),
        answers: answered.answers,
        counted: answered.counted,
        make: Duration::ZERO,
        look_up: answered.time,
        made: Made {
            items: nodes.size() as f64 / NODE / casters,
            kept: (nodes.size() + triangles.size()) as f64 / casters,
            ..Made::default()
        },
        bytes_walked: NODE,
        bytes_tested: TRIANGLE,
        bytes_more: 0.0,
        caster_walks: None,
    }))
}
