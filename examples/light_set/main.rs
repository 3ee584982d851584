//! A forward renderer with three spots and a sun in one light set: `cargo run --release --example light_set`. Writes `light_set.png`.
//!
//! With `--compare` it plays the same picture in turn with a program that was written by hand for exactly that, and prints how long
//! frames take beside its; with `--casters` it prints what preparing 10,000 casters takes; with `--lists [SCENE]...` what lists of all casters take,
//! made anew by the device, beside a map.

mod by_hand;
mod compare;
mod deferred;
mod lists;
mod scene;

use anyhow::Result;
use scene::{Device, Stage};

fn main() -> Result<()> {
    let argument = std::env::args().nth(1);
    match argument.as_deref() {
        None => picture(),
        Some("--compare") => compare::frames(),
        Some("--casters") => compare::casters(),
        Some("--lists") => {
            let names: Vec<String> = std::env::args().skip(2).collect();
            lists::lists(&names)
        }
        Some(other) => {
            anyhow::bail!("`{other}` is no option; use `--compare`, `--casters`, `--lists` or none")
        }
    }
}

/// Draws a frame and writes it.
fn picture() -> Result<()> {
    let device = Device::open()?;
    let mut stage = Stage::new(&device, scene::pcf())?;
    stage.frame(&device, 0.0, deferred::Picture::Forward)?;
    let pixels = stage.read(&device)?;
    image::save_buffer(
        "light_set.png",
        &pixels,
        scene::SIZE.x,
        scene::SIZE.y,
        image::ColorType::Rgba8,
    )?;
    println!(
        "light_set.png, {}x{}, {} casters, {} lights, made by {}",
        scene::SIZE.x,
        scene::SIZE.y,
        stage.set.caster_count(),
        scene::LIGHTS,
        device.name
    );
    Ok(())
}
