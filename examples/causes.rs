//! A picture of each cause of error: the mask beside what is wrong with it.
//!
//! `cargo run --release --example causes [FOLDER]`; the folder is `docs/causes` if none is given.

use std::{fs, path::PathBuf};
use umbrage::{
    Backend, Camera, Geometry, ShadowTechnique as _, View, cpu::Cpu, metrics::attribute,
};
use umbrage_lab::{causes::faults, output::png};
use umbrage_plan::truth::{TruthOptions, trace};

fn main() -> anyhow::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("docs/causes"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let mut cpu = Cpu::new();
    for fault in faults() {
        let scene = umbrage::scenes::by_argument(fault.scene)?;
        let geometry = Geometry::bake(&scene)?;
        let camera = &scene.cameras[0];
        let light = &scene.lights[0];
        let find = &mut |c: &Camera, g: &Geometry| cpu.receivers(c, g);
        let truth = trace(
            camera,
            light,
            &geometry,
            &TruthOptions::default(),
            find,
            &|_, _| {},
        )?;
        let view = View::new(camera, light, &geometry).with_receivers(&truth.receivers);
        let mask = cpu.render(&view, &fault.technique.recipe(&view)?)?.mask;
        let causes = attribute(&mask, &truth.image()?)?;
        fs::write(
            folder.join(format!("{}.mask.png", fault.scene)),
            png::mask(truth.size, &mask, &truth.pixels)?,
        )?;
        fs::write(
            folder.join(format!("{}.png", fault.scene)),
            png::causes(&truth, &causes)?,
        )?;
        println!(
            "{}: {} ({}): {:?}",
            fault.scene,
            fault.technique.name(),
            fault.technique.settings(),
            fault.cause
        );
    }
    println!("pictures: {}", folder.display());
    Ok(())
}
