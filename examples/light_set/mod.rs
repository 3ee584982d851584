//! A forward renderer with three spots and a sun in one light set, and the same program written by hand.

mod by_hand;
mod compare;
mod deferred;
mod lists;
mod scene;

pub use compare::{casters, frames, ratios};
pub use lists::lists;

use anyhow::Result;
use scene::{Device, Stage};
use umbrage::wgpu::AdapterChoice;

/// Draws a frame and writes it as `light_set.png`.
///
/// # Errors
/// Errors without a graphics adapter, or if the file can't be written.
pub fn picture() -> Result<()> {
    let device = Device::open(&AdapterChoice::from_env())?;
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
