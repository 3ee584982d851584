//! Crops of penumbrae by three techniques.

use anyhow::Result;
use image::{GrayImage, buffer::ConvertBuffer as _, imageops::crop_imm};
use std::path::Path;
use umbrage::{
    Backend as _, Geometry, ShadowTechnique, View,
    cpu::Cpu,
    glam::UVec2,
    techniques::{MapTechnique, Pcss, Soft, Traced},
};
use umbrage_examples::sheet::Sheet;

const SIZE: UVec2 = UVec2::new(1280, 720);
const CROP: UVec2 = UVec2::new(320, 240);
/// Distance between candidate positions of a crop, pixels.
const STEP: usize = 40;

pub(crate) fn write(file: &Path) -> Result<()> {
    let techniques: [(&str, &dyn ShadowTechnique); 3] = [
        ("pcss", &MapTechnique::<Pcss>::default()),
        ("rays", &Traced { samples: 12 }),
        ("soft", &Soft::default()),
    ];
    let mut cpu = Cpu::new();
    let mut sheet = Sheet::new(3);
    for name in ["nave-soft", "street-soft", "dancer-soft"] {
        let scene = umbrage::scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].with_size(SIZE);
        let receivers = cpu.receivers(&camera, &geometry)?;
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        let mut masks = Vec::new();
        for (label, technique) in techniques {
            let shadows = cpu.render(&view, &technique.recipe(&view)?)?;
            println!("{name}: {label} took {:.0?}", shadows.timings.total());
            masks.push(shadows.mask);
        }
        let [left, top] = most_penumbra(&masks[2]).map(|place| place as u32);
        for mask in &masks {
            let grey =
                |x, y| image::Luma([(mask[(y * SIZE.x + x) as usize] * 255.0).round() as u8]);
            let image = GrayImage::from_fn(SIZE.x, SIZE.y, grey);
            let part = crop_imm(&image, left, top, CROP.x, CROP.y).to_image();
            sheet.push(part.convert());
        }
    }
    sheet.save(file)
}

/// Returns the corner of the crop with the largest penumbra.
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
