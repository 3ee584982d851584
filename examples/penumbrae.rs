//! Crops of penumbrae by `pcss`, by as many rays as take about as long as `soft`, and by `soft`.
//!
//! `cargo run --release --example penumbrae [FOLDER]`; the folder is `docs/soft` if none is given.

use std::{fs, path::PathBuf};
use umbrage::{
    Backend, Geometry, ShadowTechnique, View,
    cpu::Cpu,
    glam::UVec2,
    techniques::{MapTechnique, Pcss, Soft, Traced},
};

const SIZE: UVec2 = UVec2::new(1280, 720);
const CROP: UVec2 = UVec2::new(320, 240);
/// Crops are looked for at places so many pixels apart.
const STEP: usize = 40;

fn main() -> anyhow::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("docs/soft"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let techniques: [(&str, &dyn ShadowTechnique); 3] = [
        ("pcss", &MapTechnique::<Pcss>::default()),
        ("rays", &Traced { samples: 12 }),
        ("soft", &Soft::default()),
    ];
    let mut cpu = Cpu::new();
    for name in ["nave-soft", "street-soft", "dancer-soft"] {
        let scene = umbrage::scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].resized(SIZE);
        let receivers = cpu.receivers(&camera, &geometry)?;
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        let mut masks = Vec::new();
        for (label, technique) in techniques {
            let shadows = cpu.render(&view, &technique.recipe(&view)?)?;
            println!("{name}: {label} took {:.0?}", shadows.timings.total());
            masks.push((label, shadows.mask));
        }
        let at = most_penumbra(&masks[2].1);
        for (label, mask) in &masks {
            save(&folder.join(format!("{name}.{label}.png")), mask, at)?;
        }
    }
    println!("pictures: {}", folder.display());
    Ok(())
}

/// Returns the corner of the crop with the most half-shadow in it.
fn most_penumbra(mask: &[f32]) -> [usize; 2] {
    let size = SIZE.as_usizevec2();
    let crop = CROP.as_usizevec2();
    let mut best = ([0, 0], 0.0);
    for y in (0..=size.y - crop.y).step_by(STEP) {
        for x in (0..=size.x - crop.x).step_by(STEP) {
            let rows = (y..y + crop.y).map(|row| &mask[row * size.x + x..][..crop.x]);
            let half_shadow: f32 = rows.flatten().map(|v| v * (1.0 - v)).sum();
            if half_shadow > best.1 {
                best = ([x, y], half_shadow);
            }
        }
    }
    best.0
}

fn save(path: &std::path::Path, mask: &[f32], at: [usize; 2]) -> anyhow::Result<()> {
    let crop = CROP.as_usizevec2();
    let mut bytes = Vec::with_capacity(crop.x * crop.y);
    for row in at[1]..at[1] + crop.y {
        let part = &mask[row * SIZE.x as usize + at[0]..][..crop.x];
        bytes.extend(part.iter().map(|v| (v * 255.0).round() as u8));
    }
    image::save_buffer(path, &bytes, CROP.x, CROP.y, image::ColorType::L8)?;
    Ok(())
}
