//! Pictures of what `exact` asks: each receiver's cell, the length of its list, and where one caster covers the whole cell.
//!
//! `cargo run --profile measure --example lists [FOLDER]`; the folder is `docs/exact` if none is given.

use std::{fs, path::PathBuf};
use umbrage::{
    Backend, Geometry, ShadowTechnique, View,
    cpu::Cpu,
    glam::UVec2,
    techniques::{AskedCell, Exact},
};

/// As large as the page shows them, three in a row.
const SIZE: UVec2 = UVec2::new(480, 270);

/// Colours of lists of up to 1, 2, 4, 8, 16, 32 casters, and of more.
const SCALE: [[u8; 3]; 7] = [
    [13, 8, 135],
    [84, 2, 163],
    [139, 10, 165],
    [185, 50, 137],
    [219, 92, 104],
    [244, 136, 73],
    [252, 206, 37],
];

/// Of receivers behind the cover of their cell.
const COVERED: [u8; 3] = [40, 40, 40];

/// Of receivers that face away, or that nothing can hide.
const NOT_ASKED: [u8; 3] = [225, 225, 225];

fn main() -> anyhow::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("docs/exact"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let mut cpu = Cpu::new();
    for name in ["street", "nave", "dancer"] {
        let scene = umbrage::scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].resized(SIZE);
        let receivers = cpu.receivers(&camera, &geometry)?;
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        let exact = Exact::default();
        let cells = exact.asked_cells(&view)?;
        save(
            &folder.join(format!("{name}.lists.png")),
            cells.iter().map(length_color),
        )?;
        save(
            &folder.join(format!("{name}.cells.png")),
            cells.iter().map(cell_color),
        )?;
        let mask = cpu.render(&view, &exact.recipe(&view)?)?.mask;
        save(
            &folder.join(format!("{name}.mask.png")),
            mask.iter().map(|v| [(v * 255.0) as u8; 3]),
        )?;
        println!("{name}: {}", told(&cells));
    }
    println!("pictures: {}", folder.display());
    Ok(())
}

fn length_color(cell: &Option<AskedCell>) -> [u8; 3] {
    match cell {
        None => NOT_ASKED,
        Some(cell) if cell.is_covered => COVERED,
        Some(cell) => {
            let step = cell.length.max(1).next_power_of_two().trailing_zeros() as usize;
            SCALE[step.min(SCALE.len() - 1)]
        }
    }
}

/// A colour of each cell's own, darker where it covers.
fn cell_color(cell: &Option<AskedCell>) -> [u8; 3] {
    let Some(cell) = cell else {
        return NOT_ASKED;
    };
    let hash = cell.number.wrapping_mul(0x9e37_79b9);
    let part = |shift: u32| 90 + (hash >> shift & 127) as u8;
    let color = [part(8), part(16), part(24)];
    color.map(|c| if cell.is_covered { c / 3 } else { c })
}

fn told(cells: &[Option<AskedCell>]) -> String {
    let asked: Vec<&AskedCell> = cells.iter().flatten().collect();
    let covered = asked.iter().filter(|cell| cell.is_covered).count();
    let walked = asked.iter().filter(|cell| !cell.is_covered);
    let casters: u64 = walked.map(|cell| u64::from(cell.length)).sum();
    let mean = casters as f64 / (asked.len() - covered).max(1) as f64;
    format!(
        "{} receivers face the light within the grid, {covered} of them lie behind a caster that covers their cell; the lists of the \
         others hold {mean:.1} casters in the mean",
        asked.len()
    )
}

fn save(path: &std::path::Path, colors: impl Iterator<Item = [u8; 3]>) -> anyhow::Result<()> {
    let bytes: Vec<u8> = colors.flatten().collect();
    image::save_buffer(path, &bytes, SIZE.x, SIZE.y, image::ColorType::Rgb8)?;
    Ok(())
}
