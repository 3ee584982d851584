//! Tests of whole recipes: the same bits for all threads and instructions, and receivers against
//! simple geometry.

use crate::stage::{SIZE, bits, difference, geometry, recipe, render, same_on_all_backends, view};
use umbrage_core::{
    Backend, Image, NO_TRIANGLE, Recipe, Shadows, Simd, Snapping, View, glam::UVec2,
};
use umbrage_cpu::{Cpu, CpuOptions};

#[test]
fn threads_and_instructions_change_no_bit() {
    let expected = same_on_all_backends(&recipe());
    assert!(
        expected.mask.iter().any(|&v| v < 1.0) && expected.mask.contains(&1.0),
        "shadow and light are both visible"
    );
}

#[test]
fn the_comparison_notices_one_bit() {
    let expected = render(&mut Cpu::new());
    let spoilt = |f: fn(&mut Shadows)| {
        let mut shadows = expected.clone();
        f(&mut shadows);
        difference(&expected, &shadows)
    };
    assert_eq!(
        spoilt(|s| s.mask[99] = f32::from_bits(s.mask[99].to_bits() ^ 1)),
        Some("mask")
    );
    assert_eq!(spoilt(|s| s.images[0].texels[9000] = 0.25), Some("images"));
    assert_eq!(
        spoilt(|s| s.receivers.as_mut().unwrap().triangle[50] = 3),
        Some("receivers")
    );
}

#[test]
fn rendering_again_leaves_no_trace_of_what_was_before() {
    let view = view();
    let mut cpu = Cpu::new();
    let first = render(&mut cpu);
    let nothing_cast = Recipe {
        casts: Vec::new(),
        filters: Vec::new(),
        ..recipe()
    };
    let empty = cpu.render(&view, &nothing_cast).unwrap();
    assert!(
        empty.images[0].texels.iter().all(|&z| z == 1.0),
        "depth starts at 1"
    );
    assert!(
        empty.images[1].texels.iter().all(|&v| v == 0.0),
        "other images start at 0"
    );
    assert_eq!((empty.timings.cast, empty.timings.filter), (None, None));
    assert_eq!(difference(&first, &render(&mut cpu)), None);
}

#[test]
fn without_casters_depth_stays_at_the_far_plane() {
    let view = view();
    let geometry = geometry().without_casters();
    let view = View::new(view.camera, view.light, &geometry);
    let shadows = Cpu::new().render(&view, &recipe()).unwrap();
    assert!(shadows.images[0].texels.iter().all(|&z| z == 1.0));
    assert!(shadows.mask.iter().all(|&v| v == 1.0));
}

#[test]
fn replayed_stages_give_what_the_whole_gave() {
    let recipe = recipe();
    let view = view();
    let mut cpu = Cpu::new();
    let whole = render(&mut cpu);
    let cast = cpu
        .cast(&geometry(), &recipe.casts[0], recipe.images[0].size)
        .unwrap();
    assert_eq!(
        bits(&cast.texels),
        bits(&whole.images[0].texels[..cast.texels.len()])
    );
    let filtered = cpu.replay_filter(&recipe, 0, &whole.images).unwrap();
    assert_eq!(bits(&filtered.texels), bits(&whole.images[1].texels));
    let mask = cpu.replay_receive(&view, &recipe, &whole.images).unwrap();
    assert_eq!(bits(&mask), bits(&whole.mask));
    let mut other = whole.images.clone();
    other[1] = Image::filled_with(other[1].desc, 0.0);
    assert_ne!(
        bits(&cpu.replay_receive(&view, &recipe, &other).unwrap()),
        bits(&whole.mask)
    );
}

#[test]
fn receivers_lie_on_what_their_rays_meet() {
    let camera = view().camera;
    let geometry = geometry();
    let receivers = Cpu::new().shaded_receivers(camera, &geometry).unwrap();
    let clip_from_world = camera.space().clip_from_world();
    let mut seen = 0;
    for i in 0..receivers.len() {
        let id = receivers.triangle[i];
        if id == NO_TRIANGLE {
            assert_eq!(
                (
                    receivers.depth[i],
                    receivers.distance[i],
                    receivers.receives[i]
                ),
                (1.0, 0.0, false)
            );
            continue;
        }
        seen += 1;
        let p = receivers.position(i);
        let n = receivers.normal(i);
        let ndc = clip_from_world.project_point3(p);
        let pixel = (ndc.truncate() * UVec2::new(1, 1).as_vec2() * 0.5) * SIZE.as_vec2();
        let x = pixel.x + 0.5 * SIZE.x as f32;
        let y = 0.5 * SIZE.y as f32 - pixel.y;
        // A hundredth of a pixel, and a thousandth of the depth range: far above rounding, and far
        // below any actual error.
        assert!(
            (x - (i as u32 % SIZE.x) as f32 - 0.5).abs() < 0.01
                && (y - (i as u32 / SIZE.x) as f32 - 0.5).abs() < 0.01
        );
        assert!((ndc.z - receivers.depth[i]).abs() < 1e-3);
        assert!(((p - camera.eye()).length() - receivers.distance[i]).abs() < 1e-4);
        assert!(
            n.dot(camera.eye() - p) > 0.0
                && receivers.shading_normals[i].dot(camera.eye() - p) > 0.0
        );
        assert!((receivers.shading_normals[i].length() - 1.0).abs() < 1e-5);
        assert_eq!(receivers.receives[i], geometry.receivers().contains(&id));
    }
    assert!(
        seen > 1000 && receivers.receives.iter().filter(|&&r| r).count() < seen,
        "ground and sheet are visible"
    );
}

#[test]
fn pixels_that_receive_nothing_are_lit() {
    let shadows = render(&mut Cpu::new());
    let receivers = shadows.receivers.unwrap();
    assert!(
        receivers
            .receives
            .iter()
            .zip(&shadows.mask)
            .all(|(&receives, &v)| receives || v == 1.0)
    );
}

#[test]
fn given_receivers_are_used_as_they_are() {
    let recipe = recipe();
    let view = view();
    let mut cpu = Cpu::new();
    let mut receivers = cpu.receivers(view.camera, &geometry()).unwrap();
    let shadows = cpu
        .render(&view.with_receivers(&receivers), &recipe)
        .unwrap();
    assert!(shadows.receivers.is_none() && shadows.timings.receivers.is_none());
    assert_eq!(bits(&shadows.mask), bits(&render(&mut cpu).mask));
    receivers.receives.fill(false);
    assert!(
        cpu.render(&view.with_receivers(&receivers), &recipe)
            .unwrap()
            .mask
            .iter()
            .all(|&v| v == 1.0)
    );
}

/// Both maps and receivers use the requested rounding.
#[test]
fn another_rounding_of_vertices_reaches_maps_and_receivers() {
    let exact = render(&mut Cpu::new());
    let mut coarse =
        Cpu::with_options(&CpuOptions::default().snapping(Snapping::COARSEST)).unwrap();
    assert_eq!(coarse.snapping(), Snapping::COARSEST);
    let moved = render(&mut coarse);
    assert_ne!(bits(&exact.images[0].texels), bits(&moved.images[0].texels));
    let ids = |s: &Shadows| s.receivers.as_ref().unwrap().triangle.clone();
    assert_ne!(ids(&exact), ids(&moved));
    let default = Cpu::with_options(&CpuOptions::default().snapping(Snapping::default()));
    assert_eq!(difference(&exact, &render(&mut default.unwrap())), None);
}

#[test]
fn working_memory_stays_below_the_image() {
    let geometry = geometry();
    let size = UVec2::splat(512);
    let mut cpu = Cpu::new();
    let image = cpu.cast(&geometry, &recipe().casts[0], size).unwrap();
    assert!(cpu.working_bytes() > 0 && cpu.working_bytes() < 4 * image.texels.len());
}

#[test]
fn the_name_tells_threads_and_instructions() {
    let cpu = Cpu::with_options(&CpuOptions::default().threads(3).simd(Simd::Baseline)).unwrap();
    assert_eq!(
        (cpu.name(), cpu.kind()),
        ("cpu (3 threads, baseline)", "cpu")
    );
    println!("{}", Cpu::new().name());
}
