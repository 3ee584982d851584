//! The lists that `exact` reads for each receiver.

use anyhow::Result;
use std::path::Path;
use umbrage::{
    Backend as _, Geometry, ShadowTechnique as _, View,
    cpu::Cpu,
    glam::UVec2,
    techniques::{Exact, QueriedCell},
};
use umbrage_examples::sheet::{Sheet, color_image};

/// Size of each of three images in a row.
const SIZE: UVec2 = UVec2::new(320, 180);

/// Colours of lists of up to 1, 2, 4, 8, 16, 32 casters, and of longer ones.
const SCALE: [[u8; 3]; 7] = [
    [13, 8, 135],
    [84, 2, 163],
    [139, 10, 165],
    [185, 50, 137],
    [219, 92, 104],
    [244, 136, 73],
    [252, 206, 37],
];

/// Colour of receivers behind the cover of their cell.
const COVERED: [u8; 3] = [40, 40, 40];

/// Colour of receivers that face away, or that nothing can hide.
const NOT_QUERIED: [u8; 3] = [225, 225, 225];

pub(crate) fn write(file: &Path) -> Result<()> {
    let mut cpu = Cpu::new();
    let mut sheet = Sheet::new(3);
    for name in ["street", "nave", "dancer"] {
        let scene = umbrage::scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].with_size(SIZE);
        let receivers = cpu.receivers(&camera, &geometry)?;
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        let exact = Exact::default();
        let cells = exact.queried_cells(&view)?;
        sheet.push(color_image(SIZE, |i| length_color(&cells[i])));
        sheet.push(color_image(SIZE, |i| cell_color(&cells[i])));
        sheet.push_mask(SIZE, &cpu.render(&view, &exact.recipe(&view)?)?.mask);
        println!("{name}: {}", summary(&cells));
    }
    sheet.save(file)
}

fn length_color(cell: &Option<QueriedCell>) -> [u8; 3] {
    match cell {
        None => NOT_QUERIED,
        Some(cell) if cell.is_covered => COVERED,
        Some(cell) => {
            let step = cell.length.max(1).next_power_of_two().trailing_zeros() as usize;
            SCALE[step.min(SCALE.len() - 1)]
        }
    }
}

/// Returns a distinct colour for each cell, darker if the cell has a cover.
fn cell_color(cell: &Option<QueriedCell>) -> [u8; 3] {
    let Some(cell) = cell else {
        return NOT_QUERIED;
    };
    let hash = cell.number.wrapping_mul(0x9e37_79b9);
    let part = |shift: u32| 90 + (hash >> shift & 127) as u8;
    let color = [part(8), part(16), part(24)];
    color.map(|c| if cell.is_covered { c / 3 } else { c })
}

/// Returns the lengths of the lists.
fn summary(cells: &[Option<QueriedCell>]) -> String {
    let requested: Vec<&QueriedCell> = cells.iter().flatten().collect();
    let covered = requested.iter().filter(|cell| cell.is_covered).count();
    let walked = requested.iter().filter(|cell| !cell.is_covered);
    let casters: u64 = walked.map(|cell| u64::from(cell.length)).sum();
    let mean = casters as f64 / (requested.len() - covered).max(1) as f64;
    format!(
        "{} receivers face the light within the grid, {covered} of them lie behind a caster that covers their cell; the lists of the \
         others hold {mean:.1} casters in the mean",
        requested.len()
    )
}
