//! Tests of absurd numbers in all inputs of a light set. The result is an error or a light without
//! shadows, and never a panic, a hang or an error of the device.

use super::alike::World;
use glam::{Affine3A, Mat3, UVec2, Vec3};
use proptest::{prelude::*, test_runner::RngSeed};
use std::cell::Cell;
use umbrage_core::{Aabb, Camera, Light};
use umbrage_techniques::{ShadowMap, TechniquePreset, all};
use umbrage_tests::absurd_values::{camera, light, number, spoil_preset, vector};
use umbrage_wgpu::{FrameGeometry, SetFrame, ShadowedLight};

/// Greatest side of a map, texels. The subject is numbers, and not the time of large maps.
const LARGEST: u32 = 128;

/// Returns a preset with a small map. A replaced number of its side is kept if it is small.
fn on_a_small_map(preset: &TechniquePreset) -> TechniquePreset {
    let map = preset.map().map(|map| ShadowMap {
        size: map.size.min(LARGEST),
        ..*map
    });
    map.map_or(preset.clone(), |map| preset.with_map(map))
}

fn usual_camera() -> Camera {
    let eye = Vec3::new(3.0, 4.0, 5.0);
    let size = UVec2::new(12, 8);
    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.8, [0.1, 50.0], size).expect("usual")
}

fn usual_light() -> Light {
    Light::Spot {
        position: Vec3::new(1.0, 6.0, 1.0),
        direction: Vec3::NEG_Y,
        inner: 0.5,
        outer: 0.6,
        radius: 0.1,
    }
}

#[test]
fn sets_answer_or_refuse() {
    let world = World::new("cubes");
    let d = world.program.d;
    let entries = all();
    let [served, refused] = [Cell::new(0), Cell::new(0)];
    let settings = (
        0..entries.len(),
        prop::collection::vec((0..24_usize, number()), 0..3),
    );
    let lights = (
        prop_oneof![1 => light(), 1 => Just(usual_light())],
        light(),
        number(),
    );
    let places = (prop::array::uniform9(number()), vector(), vector());
    let config = ProptestConfig {
        cases: 1500,
        rng_seed: RngSeed::Fixed(12),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    proptest!(config, |((light, later, priority) in lights, camera in camera(), (entry, spoils) in settings, (turn, place, corner) in places)| {
        let refuse = |refused: &Cell<u32>| refused.set(refused.get() + 1);
        let Some(preset) = spoil_preset(&(entries[entry].preset)(), &spoils) else {
            refuse(&refused);
            return Ok(());
        };
        let scope = d.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut set = world.set();
        let added = set.add_light(ShadowedLight {
            light,
            technique: on_a_small_map(&preset).technique(),
            priority,
        });
        let Ok(id) = added else {
            refuse(&refused);
            return Ok(());
        };
        // Place a caster arbitrarily, and change an arbitrary part.
        let placed = Affine3A::from_mat3_translation(Mat3::from_cols_array(&turn), place);
        let mesh = world.meshes(&mut set)[0];
        let _ = set.add_caster(mesh, placed);
        let _ = set.touch(&Aabb { min: place, max: corner });
        let camera = camera.unwrap_or_else(|_| usual_camera());
        for later in [None, Some(later)] {
            if let Some(later) = later
                && set.set_light(id, later).is_err()
            {
                break;
            }
            let frame = SetFrame {
                camera: &camera,
                geometry: Some(FrameGeometry {
                    triangles: &world.geometry,
                    revision: 0,
                }),
            };
            if set.prepare(&frame).is_err() {
                refuse(&refused);
                break;
            }
            let mut encoder = world.program.encoder();
            prop_assert!(set.encode(&mut encoder).is_ok(), "prepared, and not encoded");
            d.queue.submit([encoder.finish()]);
            let is_served = set.unserved_lights().next().is_none();
            let count = if is_served { &served } else { &refused };
            count.set(count.get() + 1);
        }
        d.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
        let fault = pollster::block_on(scope.pop());
        prop_assert!(fault.is_none(), "{preset:?} under {light:?}, then {later:?}: {fault:?}");
    });
    // Both outcomes must occur, or the test is void.
    assert!(
        served.get() > 30 && refused.get() > 30,
        "{served:?} {refused:?}"
    );
}
