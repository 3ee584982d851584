//! Unit tests of fits; snapshots of their matrices are in the test suite.

use super::*;
use crate::{
    LayerPicker, Split,
    geometry::{Geometry, aabb::Aabb},
    math::transform,
    scene::{Instance, Mesh, Scene, camera::Camera},
};
use glam::{Affine3A, UVec2};

/// Returns a floor of 20 m through (0, 0, 0) and a small quad `h` above it.
fn floor_and_quad(h: f32) -> Geometry {
    let corner = |x, z| Vec3::new(x, 0.0, z);
    let corners = vec![
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let quad = Mesh::new("quad", corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let place = |scale: f32, y: f32| {
        let up = Affine3A::from_translation(Vec3::Y * y);
        Instance::new(0, up * Affine3A::from_scale(Vec3::new(scale, 1.0, scale)))
    };
    let instances = vec![place(10.0, 0.0), place(0.002, h)];
    let scene = Scene {
        name: "test".into(),
        meshes: vec![quad],
        instances,
        ..Scene::default()
    };
    Geometry::bake(&scene).unwrap()
}

fn spot(position: Vec3, direction: Vec3) -> Light {
    Light::Spot {
        position,
        direction,
        inner: 0.3,
        outer: 0.6,
        radius: 0.0,
    }
}

fn space(light: &Light, geometry: &Geometry) -> LightSpace {
    let size = UVec2::splat(8);
    let camera = Camera::perspective(
        Vec3::splat(9.0),
        Vec3::ZERO,
        Vec3::Y,
        1.0,
        [0.1, 99.0],
        size,
    )
    .unwrap();
    Fit::Tight
        .light_space(&View::new(&camera, light, geometry), 1024, 1.0)
        .unwrap()
}

/// The floor crosses the light's plane, but is outside its cone above the ground.
#[test]
fn a_floor_that_crosses_the_lamps_plane_costs_no_precision() {
    let light = spot(Vec3::new(0.0, 5.0, 0.0), Vec3::new(0.6, -0.8, 0.0));
    let m = space(&light, &floor_and_quad(1.0)).clip_from_view;
    // depth = f/(f-n) (1 - n/distance): the near plane is where it is 0.
    let near = m.w_axis.z / m.z_axis.z;
    assert!(near > 3.5 && near < 4.2, "{near}");
}

/// A ceiling just below an area light is outside its map. Lookups near the map's edge would search
/// there for blockers, but a map cannot contain them, so they must not move its near plane to the
/// light.
#[test]
fn casters_next_to_the_map_cost_no_precision() {
    let position = Vec3::new(0.0, 5.0, 0.0);
    let direction = Vec3::NEG_Y;
    let lamp = Light::Spot {
        position,
        direction,
        inner: 0.3,
        outer: 0.6,
        radius: 0.5,
    };
    let corner = |x, z| Vec3::new(x, 0.0, z);
    let corners = vec![
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let quad = Mesh::new("quad", corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let place = |at: Vec3, side: f32| {
        Instance::new(
            0,
            Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::new(side, 1.0, side)),
        )
    };
    let floor = place(Vec3::ZERO, 4.0);
    let table = place(Vec3::Y, 0.5);
    let ceiling = [-1.0, 1.0].map(|side| place(Vec3::new(side * 2.4, 4.8, 0.0), 2.0));
    let near = |instances: &[Instance]| {
        let scene = Scene {
            meshes: vec![quad.clone()],
            instances: instances.to_vec(),
            ..Scene::default()
        };
        let m = space(&lamp, &Geometry::bake(&scene).unwrap()).clip_from_view;
        m.w_axis.z / m.z_axis.z
    };
    let bare = near(&[floor, table]);
    assert!(bare > 3.5, "the table is the first caster: {bare}");
    let [left, right] = ceiling;
    assert_eq!(near(&[floor, table, left, right]), bare);
}

/// No receiver is moved beyond the far plane, for every tilt of the light and with a caster close
/// to it.
#[test]
fn rounding_keeps_receivers_before_the_far_plane() {
    for i in 0..50 {
        let turn = i as f32 * 0.37;
        let direction = Vec3::new(turn.cos() * 0.4, -1.0, turn.sin() * 0.4);
        let geometry = floor_and_quad(4.99);
        let clip_from_world =
            space(&spot(Vec3::new(0.0, 5.0, 0.0), direction), &geometry).clip_from_world();
        for p in geometry.vertices_of(geometry.receivers()) {
            let clip = transform(clip_from_world, p);
            assert!(
                clip.w <= 0.0 || clip.z / clip.w <= 1.0,
                "{p} at tilt {i}: {}",
                clip.z / clip.w
            );
        }
    }
}

/// A cached fit equals a recomputed one. A scene with the same cache gets the first scene's fit,
/// which shows that the cache is used.
#[test]
fn a_memory_gives_what_was_found() {
    let light = spot(Vec3::new(0.0, 5.0, 0.0), Vec3::new(0.28, -0.96, 0.0));
    let size = UVec2::splat(8);
    let camera = Camera::perspective(
        Vec3::splat(9.0),
        Vec3::ZERO,
        Vec3::Y,
        1.0,
        [0.1, 99.0],
        size,
    )
    .unwrap();
    let [low, high] = [1.0, 3.0].map(floor_and_quad);
    let memory = FitMemory::default();
    let fit = |geometry: &Geometry, memory: Option<&FitMemory>, size, layout| {
        let view = View {
            fits: memory,
            ..View::new(&camera, &light, geometry)
        };
        Fit::Tight.light_spaces(layout, &view, size, 1.0)
    };
    let mut found = Vec::new();
    for (size, layout) in [
        (256, Layout::Single),
        (512, Layout::Single),
        (256, Layout::Cube),
    ] {
        let rebuilt = fit(&low, None, size, layout);
        assert_eq!(fit(&low, Some(&memory), size, layout), rebuilt);
        assert_ne!(
            fit(&high, None, size, layout),
            rebuilt,
            "the scenes have the same fit"
        );
        assert_eq!(fit(&high, Some(&memory), size, layout), rebuilt);
        found.push(rebuilt);
    }
    assert!(found[0] != found[1] && found[0] != found[2]);
    let receivers = crate::gbuffer::receivers::Receivers::default();
    assert!(
        View::new(&camera, &light, &low)
            .with_fits(&memory)
            .with_receivers(&receivers)
            .fits
            .is_none()
    );
}

/// A light set knows only the box around its casters.
#[test]
fn of_a_box_the_tight_fit_holds_all() {
    let size = UVec2::splat(8);
    let camera = Camera::perspective(
        Vec3::splat(9.0),
        Vec3::ZERO,
        Vec3::Y,
        1.0,
        [0.1, 99.0],
        size,
    )
    .unwrap();
    let sun = Light::Directional {
        direction: Vec3::new(0.3, -0.9, 0.1),
        angular_diameter: 0.0,
    };
    let bulb = Light::Point {
        position: Vec3::new(0.0, 9.0, 0.0),
        radius: 0.0,
    };
    let geometry = floor_and_quad(1.0);
    for light in [&sun, &bulb, &spot(Vec3::Y * 9.0, Vec3::NEG_Y)] {
        let with_triangles = View::new(&camera, light, &geometry);
        let box_alone = View {
            geometry: None,
            ..with_triangles
        };
        let spaces = |fit: Fit, view| fit.light_spaces(Layout::Auto, view, 256, 1.0).unwrap();
        assert_eq!(
            spaces(Fit::Tight, &box_alone),
            spaces(Fit::Whole, &box_alone)
        );
        // The floor casts, too: it fills the sun's box and the spot's cone, but not the bulb's
        // cube.
        let is_tighter = spaces(Fit::Tight, &with_triangles) != spaces(Fit::Whole, &with_triangles);
        assert_eq!(is_tighter, light.kind() == "point");
    }
}

/// Side of the cascades' maps, texels.
const SIDE: u32 = 256;

/// Returns the cascades of a view of which only the casters' box is known.
fn cascades_of_box(camera: &Camera, casters: Aabb, sun: Vec3, split: Split) -> LightSpaces {
    let light = Light::Directional {
        direction: sun.normalize(),
        angular_diameter: 0.0,
    };
    let view = View {
        nearest_caster: 0.0,
        camera,
        light: &light,
        casters,
        geometry: None,
        receivers: None,
        fits: None,
    };
    let cascades = Cascades {
        count: 3,
        split,
        ..Cascades::default()
    };
    Fit::Tight
        .light_spaces(Layout::Cascades(cascades), &view, SIDE, 2.0)
        .unwrap()
}

/// Returns whether the cascade in which a receiver is looked up has its caster, too. Both are at
/// the same place across the light.
fn is_caster_on_map(spaces: &LightSpaces, receiver: Vec3, caster: Vec3) -> bool {
    let picker = LayerPicker::new(spaces, SIDE);
    let layer = picker.layer_at(receiver).unwrap();
    let clip = transform(picker.clip_from_world(layer), caster);
    let is_on = clip.x.abs() < 1.0 && clip.y.abs() < 1.0 && clip.z > 0.0 && clip.z < 1.0;
    is_on && spaces.is_needed(layer)
}

/// The box is wholly outside the camera's view, or far above all that is seen. Its shadow on a
/// floor that is no caster is in the view.
#[test]
fn shadows_of_a_box_alone_are_on_cascades_wherever_they_fall() {
    let casters = Aabb {
        min: Vec3::new(28.0, 5.0, -32.0),
        max: Vec3::new(32.0, 9.0, -28.0),
    };
    for far in [120.0, 1e9] {
        let eye = Vec3::new(0.0, 2.0, 0.0);
        let size = UVec2::splat(64);
        let camera =
            Camera::perspective(eye, eye - Vec3::Z, Vec3::Y, 0.9, [0.1, far], size).unwrap();
        let clip_from_world = camera.space().clip_from_world();
        for sun in [
            Vec3::new(-1.0, -0.25, 0.0),
            Vec3::new(-1.0, -0.2, -0.8),
            Vec3::new(-1.0, -0.3, 0.6),
        ] {
            for split in [Split::Log, Split::Practical { lambda: 0.3 }] {
                let spaces = cascades_of_box(&camera, casters, sun, split);
                let mut seen = 0;
                for corner in casters.corners() {
                    let on_floor = corner + sun * (corner.y / -sun.y);
                    let clip = transform(clip_from_world, on_floor);
                    let is_seen = clip.w > 0.0 && clip.x.abs() < clip.w && clip.y.abs() < clip.w;
                    if is_seen && clip.z < clip.w {
                        seen += 1;
                        let is_on = is_caster_on_map(&spaces, on_floor, corner);
                        assert!(is_on, "{corner} under {sun}, {split:?}");
                    }
                }
                assert!(seen > 0, "no shadow in view under {sun}");
            }
        }
        // The light shines away from the view.
        let away = cascades_of_box(&camera, casters, Vec3::new(1.0, -0.2, 0.0), Split::Log);
        assert!((0..3).all(|i| !away.is_needed(i)));
    }
}
