use glam::UVec2;
use umbrage_core::{Backend, DepthPlanes, Geometry, ShadowTechnique, Snapping, View};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_techniques::ShadowVolumes;

#[test]
fn scratch() {
    for name in ["cubes", "c6-slit", "low-sun-5", "flat-receivers", "stairs"] {
        let scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let camera = scene.cameras[0].resized(UVec2::new(160, 120));
        let view = View::new(&camera, &scene.lights[0], &geometry);
        let plain_receivers = Cpu::new().receivers(&camera, &geometry).expect("ok");
        let recipe = ShadowVolumes::default().plan(&view.with_receivers(&plain_receivers)).expect("ok");
        let plain = Cpu::new().render(&view, &recipe).expect("plays");
        let truth = {
            let mut cpu = Cpu::new();
            let mut find = |camera: &_, geometry: &_| cpu.receivers(camera, geometry);
            umbrage_lab::truth::trace(
                &camera,
                &scene.lights[0],
                &geometry,
                &umbrage_lab::truth::TruthOptions::default(),
                &mut find,
                &|_, _| {},
            )
            .expect("ok")
        };
        let mut ambiguous = vec![false; truth.visibility.len()];
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let moved = camera.nudged(glam::Vec2::new(x, y) / 8.0);
            let mut cpu = Cpu::new();
            let mut find = |camera: &_, geometry: &_| cpu.receivers(camera, geometry);
            let t = umbrage_lab::truth::trace(
                &moved,
                &scene.lights[0],
                &geometry,
                &umbrage_lab::truth::TruthOptions::default(),
                &mut find,
                &|_, _| {},
            )
            .expect("ok");
            if name == "c6-slit" {
                println!("nudge {x} {y}: {} {:?} {}", t.visibility[3046], t.pixels[3046], t.receivers.triangle[3046]);
            }
            for i in 0..ambiguous.len() {
                ambiguous[i] |= t.visibility[i] != truth.visibility[i] || t.pixels[i] != truth.pixels[i];
            }
        }
        if name == "c6-slit" {
            let gpu_ = umbrage_tests::gpu::gpu().render(&view, &recipe).expect("plays");
            let mut cpu = Cpu::with_options(&CpuOptions::default().snapping(Snapping::COARSEST)).expect("valid");
            let model = cpu.render(&view, &recipe).expect("plays");
            for i in [19 * 160 + 6, 20 * 160 + 46] {
                println!(
                    "{i}: plain {} {} truth {} {:?} model {} {} gpu {} {}",
                    plain.mask[i],
                    plain.receivers.as_ref().unwrap().triangle[i],
                    truth.visibility[i],
                    truth.pixels[i],
                    model.mask[i],
                    model.receivers.as_ref().unwrap().triangle[i],
                    gpu_.mask[i],
                    gpu_.receivers.as_ref().unwrap().triangle[i]
                );
            }
        }
        if name == "c6-slit" {
            use std::sync::Arc;
            use umbrage_core::{Cast, CastMode, Faces, Format, ImageDesc, Source};
            let Source::Faces(faces) = &recipe.casts.last().expect("counts").source else { panic!() };
            let m = recipe.casts[0].space.clip_from_world();
            for t in &faces.triangles {
                println!(
                    "{:?} {:?}",
                    t,
                    t.map(|v| m * faces.vertices[v as usize]).map(|c| (
                        c,
                        (c.x / c.w * 80.0 + 80.0 - 0.5) * 16.0,
                        (60.0 - c.y / c.w * 60.0 - 0.5) * 16.0
                    ))
                );
            }
            let layers = faces.triangles.len() as u32;
            let mut each = recipe.clone();
            each.images = vec![
                ImageDesc { label: "t", size: camera.size, layers: layers + 1, format: Format::Depth32 },
                recipe.images[1],
            ];
            each.keep_images = true;
            each.casts = vec![Cast { layer: layers, ..recipe.casts[0].clone() }];
            for (k, t) in faces.triangles.iter().enumerate() {
                let one = Faces { vertices: faces.vertices.clone(), triangles: vec![*t] };
                each.casts.push(Cast {
                    source: Source::Faces(Arc::new(one)),
                    mode: CastMode::Nearest,
                    image: 0,
                    layer: k as u32,
                    ..recipe.casts.last().unwrap().clone()
                });
            }
            each.receive.inputs = vec![0];
            let mut cpu = Cpu::with_options(&CpuOptions::default().snapping(Snapping::COARSEST)).expect("valid");
            let a = cpu.render(&view, &each).expect("plays").images.swap_remove(0).texels;
            let c = Cpu::new().render(&view, &each).expect("plays").images.swap_remove(0).texels;
            let n = 160 * 120;
            for i in [3046, 3246] {
                for k in 0..=layers as usize {
                    if a[k * n + i] < 1.0 || c[k * n + i] < 1.0 {
                        println!(
                            "   {i} {k}: model {:.8} plain {:.8}; next row {:.8} {:.8}",
                            a[k * n + i],
                            c[k * n + i],
                            a[k * n + i + 160],
                            c[k * n + i + 160]
                        );
                    }
                }
            }
        }
        for planes in [DepthPlanes::Unsnapped, DepthPlanes::Snapped] {
            for sub_pixel_bits in [4, 5, 6, 8] {
                let mut cpu = Cpu::with_options(&CpuOptions::default().snapping(Snapping { sub_pixel_bits, planes }))
                    .expect("valid");
                let other = cpu.render(&view, &recipe).expect("plays");
                let (a, b) = (plain.receivers.as_ref().unwrap(), other.receivers.as_ref().unwrap());
                let wrong: Vec<usize> = (0..plain.mask.len())
                    .filter(|&i| {
                        truth.pixels[i] == umbrage_core::metrics::Pixel::Counted
                            && truth.visibility[i] != other.mask[i]
                            && a.triangle[i] == b.triangle[i]
                            && !ambiguous[i]
                    })
                    .collect();
                println!(
                    "{name} {sub_pixel_bits} {planes:?}: {} wrong {:?}",
                    wrong.len(),
                    wrong
                        .iter()
                        .take(24)
                        .map(|&i| (
                            i % 160,
                            i / 160,
                            truth.visibility[i],
                            [i - 1, i + 1, i - 160, i + 160].map(|j| truth.visibility[j]),
                            a.triangle[i]
                        ))
                        .collect::<Vec<_>>()
                );
            }
        }
    }
}
