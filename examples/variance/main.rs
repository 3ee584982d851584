//! Bring your own technique: variance shadow maps, consisting of one cast, three filters and one
//! receive, on both backends. `cargo run --example variance` writes `variance-cpu.png` and, if
//! there is an adapter, `variance-wgpu.png`.

use umbrage::{BackendChoice, Geometry, ShadowTechnique, View, techniques::ShadowMap};
use umbrage_examples::variance::Variance;

fn main() -> anyhow::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "cubes".to_owned());
    let scene = umbrage::scenes::by_argument(&path)?;
    let geometry = Geometry::bake(&scene)?;
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = Variance {
        map: ShadowMap::default(),
        radius: 2,
        least_variance: 1e-7,
    }
    .recipe(&view)?;
    for choice in [BackendChoice::Cpu, BackendChoice::Wgpu] {
        match umbrage::backend(choice) {
            Err(why) => println!("{choice}: {why}"),
            Ok(mut backend) => {
                let shadows = backend.render(&view, &recipe)?;
                let file = format!("variance-{choice}.png");
                let size = shadows.size;
                image::save_buffer(
                    &file,
                    &shadows.mask_bytes(),
                    size.x,
                    size.y,
                    image::ColorType::L8,
                )?;
                println!("{file}: made by {}", backend.name());
            }
        }
    }
    Ok(())
}
