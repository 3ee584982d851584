//! Candidate (a): lists of a grid of two levels, with cells by need.

use crate::{
    device::{Device, GROUP},
    frame::Frame,
    lookup::{LookUp, answer},
    outcome::{Made, Outcome},
    sort::Scan,
    tree::rects_wgsl,
};
use anyhow::{Context as _, Result, ensure};
use umbrage::join;

/// Bytes of an item, of an unsorted one, of a cell's row, and of a caster's corners.
const ITEM: f64 = 8.0;
const UNSORTED: f64 = 12.0;
const CELL: f64 = 16.0;
const CORNERS: f64 = 48.0;
const MAKE_CORNERS: f64 = 96.0;
/// Passes over all casters.
const PASSES: [&str; 4] = ["sum", "cover", "count", "fill"];

/// Runs the candidate.
pub(crate) fn run(device: &Device, frame: &Frame) -> Result<Outcome> {
    // The library's lookup has the CPU's number of tiles.
    let kernel = device.read(&frame.kernel)?;
    let offset = |name: &str| frame.kernel_offset(name);
    let tiles_a_unit = kernel[offset("grid")? + 2];
    let tiles = [kernel[offset("tiles")?], kernel[offset("tiles")? + 1]];
    let mut grid_words = frame.grid.clone();
    let face = grid_words.len() - 8;
    grid_words[face + 2] = tiles_a_unit;
    grid_words[face + 4] = tiles[0];
    grid_words[face + 5] = tiles[1];
    let faces = if frame.is_lamp { 6 } else { 1 };
    let tile_count = faces * tiles[0] * tiles[1];
    let cell_room = 5 * frame.casters / 2 + 2 * tile_count;
    let item_room = 7 * frame.casters / 2 + 2 * tile_count + 1024;
    let large_room = frame.casters + 1024;

    let place = [
        frame.casters,
        tile_count,
        cell_room,
        item_room,
        large_room,
        0,
        0,
        0,
    ];
    let item_key = frame.module("item_key")?;
    let wgsl = format!(
        "{}{}{}",
        join(&[item_key]),
        rects_wgsl(frame)?,
        include_str!("../shaders/grid.wgsl")
    );
    let entries = [
        "visit_small",
        "visit_large",
        "choose_levels",
        "place_tiles",
        "keep_counts",
        "place_cells",
        "sort_items",
    ];
    let mut programs = Vec::new();
    for does in 0..PASSES.len() {
        let constants = [("DOES", does as f64)];
        programs.push(device.program("grid", &wgsl, &entries, &constants));
    }
    let scan = Scan::new(device);

    let grid = device.uniform("grid", bytemuck::cast_slice(&grid_words));
    let made = device.uniform("made", bytemuck::cast_slice(&place));
    let words = |count: u32| device.zeros("words", 4 * u64::from(count));
    let tile_sums = words(3 * tile_count);
    let tile_cells = words(tile_count + 1);
    let tile_rows = words(2 * tile_count + 4);
    let cell_items = words(cell_room + 1);
    let covers = words(cell_room + 1);
    let cells = words(4 * (cell_room + 1));
    let unsorted = words(3 * item_room);
    let items = words(2 * item_room);
    let large = words(4 + large_room);
    let named = [
        ("grid", &grid),
        ("made", &made),
        ("corners", &frame.corners),
        ("tile_sums", &tile_sums),
        ("tile_cells", &tile_cells),
        ("tiles", &tile_rows),
        ("cell_items", &cell_items),
        ("covers", &covers),
        ("cells", &cells),
        ("unsorted", &unsorted),
        ("items", &items),
        ("large", &large),
    ];
    let caster_groups = frame.casters.div_ceil(GROUP);
    let tile_groups = tile_count.div_ceil(GROUP);
    let cell_groups = (cell_room + 1).div_ceil(GROUP);
    let tile_scan = Scan::buffers(device, tile_count);
    let cell_scan = Scan::buffers(device, cell_room + 1);
    let mut all = Vec::new();
    let visit = |does: usize, all: &mut Vec<_>| -> Result<()> {
        all.push(device.dispatch(&programs[does], "visit_small", &named, caster_groups)?);
        all.push(device.dispatch(&programs[does], "visit_large", &named, 1024)?);
        Ok(())
    };
    visit(0, &mut all)?;
    all.push(device.dispatch(&programs[0], "choose_levels", &named, tile_groups)?);
    scan.record(device, &tile_scan, &tile_cells, &mut all)?;
    all.push(device.dispatch(&programs[0], "place_tiles", &named, tile_groups)?);
    visit(1, &mut all)?;
    visit(2, &mut all)?;
    all.push(device.dispatch(&programs[0], "keep_counts", &named, cell_groups)?);
    scan.record(device, &cell_scan, &cell_items, &mut all)?;
    all.push(device.dispatch(&programs[0], "place_cells", &named, cell_groups)?);
    visit(3, &mut all)?;
    all.push(device.dispatch(&programs[0], "sort_items", &named, cell_groups)?);
    let make = device.run(&[&tile_sums, &cell_items, &covers, &cells, &large], &all)?;

    let cell_count = tile_scan.total(device)?;
    let item_count = cell_scan.total(device)?;
    let large_words = device.read(&large)?;
    let [large_count, touches] = [large_words[0], large_words[1]];
    ensure!(cell_count <= cell_room, "{cell_count} cells");
    ensure!(item_count <= item_room, "{item_count} items");
    ensure!(large_count <= large_room, "{large_count} large casters");
    let look_up = LookUp {
        wgsl: counting_lists_wgsl(frame)?,
        buffers: vec![
            ("table_0", &tile_rows),
            ("table_1", &cells),
            ("table_2", &items),
        ],
    };
    let answered = answer(device, frame, &look_up)?;
    let casters = f64::from(frame.casters.max(1));
    let [i, c] = [item_count, cell_count].map(|n| f64::from(n) / casters);
    let touched = f64::from(touches) / casters;
    let made = Made {
        items: i + c,
        bytes: MAKE_CORNERS
            // Four passes over corners and covers; sums of tiles; two passes' atomics.
            + 4.0 * CORNERS
            + 3.0 * 8.0 * touched
            + (8.0 + 4.0) * i
            + (8.0 + 4.0 + CELL + UNSORTED) * i
            // Scan, places, and the sort of items, which reads depths twice.
            + c * (4.0 * 3.0 + 2.0 * CELL + 12.0 + CELL)
            + i * (4.0 + 4.0 + UNSORTED + ITEM),
        atomics: 3.0 * touched + 2.0 * i,
        kept: CORNERS + ITEM * i + CELL * c,
        scratch: UNSORTED * i + 8.0 * c,
    };
    Ok(Outcome {
        candidate: "grid of two levels".to_owned(),
        answers: answered.answers,
        counted: answered.counted,
        make,
        look_up: answered.time,
        made,
        bytes_walked: ITEM,
        bytes_tested: CORNERS,
        // A tile, a cell, and the end of its list.
        bytes_more: 16.0 + 2.0 * CELL,
        caster_walks: None,
    })
}

/// Returns the library's lookup of lists, which counts items and tests.
fn counting_lists_wgsl(frame: &Frame) -> Result<String> {
    let text = frame.lists_wgsl();
    let (before, after) = text
        .split_once("fn receive(r: Receiver)")
        .context("exact.wgsl has no `receive`")?;
    ensure!(after.len() < 700, "`receive` is not at the end");
    let counted = before
        .replacen(
            "let items = table_2[i / 2u];",
            "walked += 1u;\n            let items = table_2[i / 2u];",
            1,
        )
        .replacen(
            "if meets_caster(o, d, rows, caster)",
            "tested += 1u;\n        if meets_caster(o, d, rows, caster)",
            1,
        );
    let added = counted.len() - before.len();
    ensure!(added == 48, "exact.wgsl has changed: {added}");
    let bindings = (0..3).map(|i| {
        let binding = 7 + i;
        format!("@group(0) @binding({binding}) var<storage, read> table_{i}: array<vec4u>;\n")
    });
    Ok(counted + &bindings.collect::<String>())
}
