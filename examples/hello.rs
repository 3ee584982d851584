//! From an OBJ file to a shadow mask: `cargo run --example hello -- model.obj`. Writes
//! `shadow.png`.

use umbrage::{
    BackendChoice, Geometry, ShadowTechnique, View,
    techniques::{MapFilter as _, Pcf, ShadowMap},
};

fn main() -> anyhow::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "cubes".to_owned());
    let scene = umbrage::scenes::by_argument(&path)?;
    let geometry = Geometry::bake(&scene)?;
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = Pcf { radius: 1 }.on(ShadowMap::default()).recipe(&view)?;
    let mut backend = umbrage::backend(BackendChoice::Auto)?;
    let shadows = backend.render(&view, &recipe)?;
    image::save_buffer(
        "shadow.png",
        &shadows.mask_bytes(),
        shadows.size.x,
        shadows.size.y,
        image::ColorType::L8,
    )?;
    println!(
        "{path}: shadow.png, {}x{}, made by {}",
        shadows.size.x,
        shadows.size.y,
        backend.name()
    );
    Ok(())
}
