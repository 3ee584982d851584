//! A minimal scene with a shadow, for tests that need no specific one.

use umbrage_core::{
    Camera, Geometry, Instance, Mesh, Scene,
    glam::{Affine3A, UVec2, Vec3},
};

/// A unit box a metre above a floor of 8 x 8 metres, all of it scaled and then moved.
///
/// # Panics
/// Never panics, since the scene is valid.
pub fn geometry(scale: f32, offset: Vec3) -> Geometry {
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
            sides_of_box("box", Vec3::splat(0.5)),
            sides_of_box("floor", Vec3::new(4.0, 0.1, 4.0)),
        ],
        instances: vec![Instance::new(0, place(1.5)), floor],
        ..Scene::default()
    };
    Geometry::bake(&scene).expect("a good scene")
}

/// Returns four sides of a box around the origin. Those towards +z and -z are open.
fn sides_of_box(name: &str, half: Vec3) -> Mesh {
    let mut corners = Vec::new();
    for z in [-1.0, 1.0] {
        for y in [-1.0, 1.0] {
            for x in [-1.0, 1.0] {
                corners.push(half * Vec3::new(x, y, z));
            }
        }
    }
    let triangles = vec![
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    Mesh::new(name, corners, triangles).expect("a good mesh")
}

/// Returns a camera that looks at the box of scale 1 from the front, right and above.
///
/// # Panics
/// Never panics, since the camera is valid.
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
