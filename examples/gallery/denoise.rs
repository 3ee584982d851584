//! Displacement denoising: the noise of a closed mesh becomes a displacement map.

use anyhow::{Context as _, Result};
use image::RgbImage;
use std::{fs, path::Path};
use umbrage::{
    Backend, BackendChoice, Camera, Geometry, Instance, Light, Mesh, Scene, ShadowTechnique, View,
    glam::{Affine3A, UVec2, Vec3},
    scenes::denoise::{DisplacementMap, Solid, roughen_mesh},
    techniques::{Bias, BlinnPhong, MapFilter as _, Pcf, ShadowMap},
};
use umbrage_examples::sheet::Sheet;

/// Amplitude of the noise in each direction along the normal, metres.
const NOISE: f32 = 0.02;
const MAP: UVec2 = UVec2::splat(256);
/// Number of averaging rounds for the clean shape: see `DisplacementMap::from_noisy_keeping_shape`.
const ROUNDS: u32 = 8;

/// Writes maps and images of a sphere and a torus, and prints the distances of their vertices from
/// the clean surface.
pub(crate) fn write(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut backend = umbrage::backend(BackendChoice::Auto)?;
    let mut sheet = Sheet::new(2);
    println!(
        "mean distance to the clean surface, noise of {} mm:",
        1e3 * NOISE
    );
    for (name, solid) in [
        ("sphere", Solid::Sphere { radius: 1.0 }),
        (
            "torus",
            Solid::Torus {
                major: 1.0,
                minor: 0.4,
            },
        ),
    ] {
        let noisy = roughen_mesh(&solid.mesh(), NOISE, 7);
        let map = DisplacementMap::from_noisy_keeping_shape(&noisy, MAP, ROUNDS)?;
        let path = folder.join(format!("{name}.map.png"));
        map.save(&path)?;
        // Apply the map from its file.
        let clean = DisplacementMap::load(&path)?.apply_to_mesh(&noisy, -1.0)?;
        let before = 1e3 * solid.mean_distance(&noisy);
        let after = 1e3 * solid.mean_distance(&clean);
        println!(
            "  {name}: {before:.2} mm, denoised {after:.2} mm: {:.0} % of it remain",
            100.0 * after / before
        );
        for mesh in [noisy, clean] {
            sheet.push(paint(&mut *backend, mesh)?);
        }
    }
    sheet.save(&folder.join("denoised.png"))
}

/// Returns a shaded image of a mesh under a distant light.
fn paint(backend: &mut dyn Backend, mesh: Mesh) -> Result<RgbImage> {
    let camera = Camera::perspective(
        Vec3::new(1.5, 1.8, 2.6),
        Vec3::ZERO,
        Vec3::Y,
        0.75,
        [0.1, 20.0],
        UVec2::splat(400),
    )?;
    let scene = Scene {
        name: "denoising".into(),
        meshes: vec![Mesh {
            normals: Vec::new(),
            ..mesh
        }],
        instances: vec![Instance::new(0, Affine3A::IDENTITY)],
        lights: vec![Light::Directional {
            direction: Vec3::new(-1.0, -1.2, -0.3),
            angular_diameter: 0.0,
        }],
        cameras: vec![camera],
        ..Scene::default()
    };
    let geometry = Geometry::bake(&scene)?;
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let map = ShadowMap {
        bias: Bias::normal_offset(2.0),
        ..ShadowMap::default()
    };
    let recipe = BlinnPhong::default()
        .shading(&scene, &view)?
        .add_to(Pcf::new(1).on(map).recipe(&view)?);
    let shadows = backend.render(&view, &recipe)?;
    let rgb = shadows.picture_bytes().context("the recipe shades")?;
    let size = shadows.size;
    RgbImage::from_raw(size.x, size.y, rgb).context("three bytes a pixel")
}
