//! Tests far from the origin, where positions are rounded: biases that move the receiver cover this
//! rounding under directional light.

use glam::{Affine3A, Quat, UVec2, Vec3};
use umbrage_core::{
    Backend, Camera, Geometry, Instance, Light, Mesh, Scene, ShadowTechnique, View,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Bias, Hard, ListedTechnique as _, MapFilter as _, Pcf, ShadowMap};

const SUN: Light = Light::Directional {
    direction: Vec3::new(0.6, -0.64, 0.48),
    angular_diameter: 0.0,
};
/// Direction of the offset, along neither an axis nor the sun's rays.
const AWAY: Vec3 = Vec3::new(0.8, 0.0, -0.6);

/// A tilted square of 6 m that is only shadowed by itself, and a camera above it, at this distance
/// from the origin.
fn square(metres: f32) -> (Geometry, Camera) {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let corners = vec![
        corner(-3.0, -3.0),
        corner(-3.0, 3.0),
        corner(3.0, 3.0),
        corner(3.0, -3.0),
    ];
    let square = Mesh::new("square", corners, vec![[0, 1, 2], [0, 2, 3]]).expect("a good mesh");
    let at = AWAY * metres;
    let tilt = Affine3A::from_rotation_translation(Quat::from_rotation_z(0.3), at);
    let scene = Scene {
        meshes: vec![square],
        instances: vec![Instance::new(0, tilt)],
        ..Scene::default()
    };
    let eye = at + Vec3::new(-3.0, 6.0, 4.0);
    let camera = Camera::perspective(eye, at, Vec3::Y, 0.8, [0.5, 50.0], UVec2::new(120, 90))
        .expect("a good camera");
    (Geometry::bake(&scene).expect("a good scene"), camera)
}

/// Returns the number of dark pixels of the square, and of all its pixels.
fn dark(technique: &dyn ShadowTechnique, metres: f32) -> (usize, usize) {
    let (geometry, camera) = square(metres);
    let mut cpu = Cpu::new();
    let receivers = cpu.receivers(&camera, &geometry).expect("valid");
    let view = View::new(&camera, &SUN, &geometry).with_receivers(&receivers);
    let mask = cpu
        .render(&view, &technique.recipe(&view).expect("served"))
        .expect("renders")
        .mask;
    let seen: Vec<f32> = (0..mask.len())
        .filter(|&i| receivers.receives[i])
        .map(|i| mask[i])
        .collect();
    (seen.iter().filter(|v| **v < 1.0).count(), seen.len())
}

#[test]
fn a_lit_plane_stays_lit_far_from_the_origin() {
    for metres in [0.0, 100.0, 1e3, 1e4, 1e5] {
        for bias in [Bias::ADAPTIVE, Bias::NORMAL_OFFSET] {
            let hard = Hard {}.on(ShadowMap {
                bias,
                ..ShadowMap::default()
            });
            let (acne, seen) = dark(&hard, metres);
            assert!(
                acne == 0 && seen > 2000,
                "{} at {metres} m: {acne} of {seen}",
                hard.settings()
            );
        }
        let pcf = Pcf::new(3).on(ShadowMap {
            bias: Bias::ADAPTIVE,
            ..ShadowMap::default()
        });
        assert_eq!(dark(&pcf, metres).0, 0, "pcf at {metres} m");
    }
}

/// Negative control: without a constant that covers rounding, the plane has acne.
#[test]
fn rounding_is_seen_where_nothing_covers_it() {
    for metres in [1e4, 1e5] {
        let bias = Bias {
            constant: 0.0,
            ..Bias::RECEIVER_PLANE
        };
        let (acne, _) = dark(
            &Hard {}.on(ShadowMap {
                bias,
                ..ShadowMap::default()
            }),
            metres,
        );
        assert!(acne > 20, "{acne} at {metres} m");
    }
}
