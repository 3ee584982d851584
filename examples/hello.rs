//! From a model to its shadows: `cargo run --example hello -- model.obj` writes `picture.png`, the
//! scene with shadows, and `shadow.png`, the mask: black where the light doesn't reach.

use umbrage::{
    BackendChoice, Geometry, ShadowTechnique, View,
    techniques::{BlinnPhong, MapFilter as _, Pcf, ShadowMap},
};

fn main() -> anyhow::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "cubes".to_owned());
    let scene = umbrage::scenes::by_argument(&path)?;
    let geometry = Geometry::bake(&scene)?;
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = Pcf::new(1).on(ShadowMap::default()).recipe(&view)?;
    // Shade the image, too. A renderer leaves this out, and uses the mask in its own shading.
    let recipe = BlinnPhong::default().shading(&scene, &view)?.add_to(recipe);
    let mut backend = umbrage::backend(BackendChoice::Auto)?;
    let shadows = backend.render(&view, &recipe)?;

    let [width, height] = shadows.size.to_array();
    let mask = shadows.mask_bytes();
    image::save_buffer("shadow.png", &mask, width, height, image::ColorType::L8)?;
    let picture = shadows.picture_bytes().unwrap_or_default();
    image::save_buffer(
        "picture.png",
        &picture,
        width,
        height,
        image::ColorType::Rgb8,
    )?;
    let backend = backend.name();
    println!("{path}: picture.png and shadow.png, {width}x{height}, computed by {backend}");
    Ok(())
}
