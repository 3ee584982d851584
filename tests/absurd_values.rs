//! Extreme and invalid numbers for all numeric inputs, for tests of error handling.

use glam::{Affine3A, Mat3, Mat4, UVec2, Vec3};
use proptest::{prelude::*, sample::select};
use umbrage_core::{Camera, Instance, Invalid, Light, Mesh, Scene, light_space::Extents};
use umbrage_techniques::TechniquePreset;

/// Extreme and non-finite 32-bit numbers, and a few usual ones.
pub fn number() -> impl Strategy<Value = f32> {
    let rims = select(vec![
        0.0,
        -0.0,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        1e-45,
        1e-30,
        -1e-30,
        1e15,
        1e30,
    ]);
    prop_oneof![2 => rims, 5 => -4.0..4.0_f32]
}

/// Three [`number`]s.
pub fn vector() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from)
}

/// Lights of all kinds.
pub fn light() -> impl Strategy<Value = Light> {
    let directional =
        (vector(), number()).prop_map(|(direction, angular_diameter)| Light::Directional {
            direction,
            angular_diameter,
        });
    let spot = (vector(), vector(), number(), number(), number()).prop_map(
        |(position, direction, inner, outer, radius)| Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius,
        },
    );
    let point =
        (vector(), number()).prop_map(|(position, radius)| Light::Point { position, radius });
    let rect = (vector(), vector(), vector()).prop_map(|(center, half_u, half_v)| Light::Rect {
        center,
        half_u,
        half_v,
    });
    let disc = (vector(), vector(), number()).prop_map(|(center, normal, radius)| Light::Disc {
        center,
        normal,
        radius,
    });
    prop_oneof![directional, spot, point, rect, disc]
}

/// Cameras from angles and from matrices, or the error if the constructor refuses the numbers. Two
/// of three are usual ones.
pub fn camera() -> impl Strategy<Value = Result<Camera, Invalid>> {
    let size = UVec2::new(12, 8);
    let planes = || [number(), number()];
    let perspective = (vector(), vector(), vector(), number(), planes()).prop_map(
        move |(eye, target, up, fov_y, near_far)| {
            Camera::perspective(eye, target, up, fov_y, near_far, size)
        },
    );
    let parallel = (vector(), vector(), vector(), number(), number(), planes()).prop_map(
        move |(eye, target, up, x, y, [near, far])| {
            let extents = Extents {
                left: -x,
                right: x,
                bottom: -y,
                top: y,
                near,
                far,
            };
            Camera::orthographic(eye, target, up, extents, size)
        },
    );
    // Arbitrary matrices, as a program may pass them.
    let matrices = (
        prop::array::uniform16(number()),
        prop::array::uniform9(number()),
        vector(),
    )
        .prop_map(move |(projection, turn, eye)| {
            Ok(Camera {
                world_from_view: Affine3A::from_mat3_translation(Mat3::from_cols_array(&turn), eye),
                clip_from_view: Mat4::from_cols_array(&projection),
                size,
            })
        });
    let usual = Just(Camera::perspective(
        Vec3::new(3.0, 4.0, 5.0),
        Vec3::ZERO,
        Vec3::Y,
        0.8,
        [0.1, 50.0],
        size,
    ));
    prop_oneof![1 => perspective, 1 => parallel, 1 => matrices, 4 => usual]
}

/// A floor and a triangle above it, with arbitrary placements.
pub fn scene() -> impl Strategy<Value = Scene> {
    let corners = prop_oneof![
        Just([
            Vec3::new(-1.0, 1.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(0.0, 1.0, 1.0)
        ]),
        [vector(), vector(), vector()],
    ];
    let placed = prop_oneof![
        3 => Just(Affine3A::IDENTITY),
        1 => (prop::array::uniform9(number()), vector())
            .prop_map(|(m, t)| Affine3A::from_mat3_translation(Mat3::from_cols_array(&m), t)),
    ];
    (corners, placed).prop_map(|(corners, placed)| {
        let triangle = Mesh {
            name: "triangle".to_owned(),
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let side = 5.0;
        let floor = Mesh {
            name: "floor".to_owned(),
            positions: vec![
                Vec3::new(-side, 0.0, -side),
                Vec3::new(-side, 0.0, side),
                Vec3::new(side, 0.0, side),
                Vec3::new(side, 0.0, -side),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        Scene {
            name: "absurd".to_owned(),
            meshes: vec![triangle, floor],
            instances: vec![
                Instance::new(0, placed),
                Instance::new(1, Affine3A::IDENTITY),
            ],
            ..Scene::default()
        }
    })
}

/// Returns settings with some of their numbers replaced. `None` if the reader refuses them.
pub fn spoil_preset(preset: &TechniquePreset, places: &[(usize, f32)]) -> Option<TechniquePreset> {
    let mut table: toml::Table = preset.to_toml().ok()?.parse().ok()?;
    for &(place, number) in places {
        let mut left = place;
        spoil(&mut table, &mut left, number);
    }
    TechniquePreset::from_toml(&toml::to_string(&table).ok()?).ok()
}

/// Replaces the number at a position in the order of a table and its subtables, if it exists.
fn spoil(table: &mut toml::Table, left: &mut usize, number: f32) {
    for (_, value) in table.iter_mut() {
        match value {
            toml::Value::Table(inner) => spoil(inner, left, number),
            toml::Value::Float(old) if *left == 0 => {
                *old = f64::from(number);
                *left = usize::MAX;
            }
            toml::Value::Integer(old) if *left == 0 => {
                // Limit sizes of maps, and so their memory.
                *old = f64::from(number).clamp(-2.0, 5e9) as i64;
                *left = usize::MAX;
            }
            toml::Value::Float(_) | toml::Value::Integer(_) => *left = left.wrapping_sub(1),
            _ => {}
        }
    }
}
