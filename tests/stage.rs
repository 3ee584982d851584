//! The smallest scene with a shadow, for tests that don't care which.

use umbrage_core::{
    Camera, Geometry, Instance, Mesh, Scene,
    glam::{Affine3A, UVec2, Vec3},
};

/// A unit box a metre above a floor of 8 x 8 metres; then everything scaled, then moved.
///
/// # Panics
/// Panics never: the scene is a good one.
pub fn geometry(scale: f32, offset: Vec3) -> Geometry {
    let corners = |half: Vec3| {
        let pick = |i: u32, bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
        (0..8)
            .map(|i| half * Vec3::new(pick(i, 1), pick(i, 2), pick(i, 4)))
            .collect::<Vec<_>>()
    };
    let sides = vec![
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    let mesh = |name, half| Mesh::new(name, corners(half), sides.clone()).expect("a good mesh");
    let place = |height| {
        let p = offset + Vec3::Y * height * scale;
        Affine3A::from_translation(p) * Affine3A::from_scale(Vec3::splat(scale))
    };
    let floor = Instance {
        casts: false,
        ..Instance::new(1, place(-0.1))
    };
    let scene = Scene {
        name: "box over a floor".to_owned(),
        meshes: vec![
            mesh("box", Vec3::splat(0.5)),
            mesh("floor", Vec3::new(4.0, 0.1, 4.0)),
        ],
        instances: vec![Instance::new(0, place(1.5)), floor],
        ..Scene::default()
    };
    Geometry::bake(&scene).expect("a good scene")
}

/// Looks at the box of scale 1 from the front, right and above.
///
/// # Panics
/// Panics never: the camera is a good one.
pub fn camera() -> Camera {
    let near_far = [0.1, 100.0];
    Camera::perspective(
        Vec3::new(3.0, 4.0, 6.0),
        Vec3::ZERO,
        Vec3::Y,
        0.8,
        near_far,
        UVec2::new(64, 48),
    )
    .expect("a good camera")
}
