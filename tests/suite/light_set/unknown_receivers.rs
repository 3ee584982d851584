//! Tests that shadows fall on receivers that a set doesn't know: surfaces that aren't casters.

use bytemuck::cast_slice;
use glam::{Affine3A, UVec2, Vec2, Vec3};
use std::sync::Arc;
use umbrage_core::{Aabb, Camera, Cascades, Layout, Light, ShadowTechnique};
use umbrage_techniques::{BeyondFar, Hard, MapFilter as _, Pcf, ShadowMap};
use umbrage_tests::{
    adapter::device,
    foreign,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{
    CasterMesh, Indices, LightSet, SetBudget, SetFrame, ShadowedLight, StillLayers, VertexLayout,
};
use wgpu::{BufferUsages, IndexFormat};

/// Points of the floor.
const SIZE: UVec2 = UVec2::new(96, 64);
/// Half the size of the floating box, whose centre is at this height.
const HALF: Vec3 = Vec3::new(2.0, 0.5, 1.5);
const HEIGHT: f32 = 5.5;
/// Half the size of the floor, as a caster: a thin box below y 0.
const FLOOR_HALF: Vec3 = Vec3::new(14.0, 0.05, 10.0);

/// Returns the camera, which sees the floor but not the box.
fn camera() -> Camera {
    let eye = Vec3::new(0.0, 3.0, 10.0);
    Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.5, [0.1, 80.0], SIZE).expect("valid")
}

/// Returns the position of a point of [`ForwardProgram::floor`].
fn floor_point(x: i32, y: i32) -> Vec3 {
    let at = (Vec2::new(x as f32, y as f32) - SIZE.as_vec2() * 0.5) * 0.25;
    Vec3::new(at.x + 0.03, 0.0, at.y + 0.01)
}

/// Returns whether the segment from `p` towards the light meets the box around `center`.
fn is_hidden(p: Vec3, center: Vec3, light: &Light) -> bool {
    let to_light = match light.position() {
        Some(position) => position - p,
        None => light.direction_from(p) * 100.0,
    };
    let a = (center - HALF - p) / to_light;
    let b = (center + HALF - p) / to_light;
    let enters = a.min(b).max_element();
    let leaves = a.max(b).min_element();
    enters <= leaves && leaves >= 0.0 && enters <= 1.0
}

/// Adds a box to a set as a caster.
fn add_box(set: &mut LightSet, center: Vec3, half: Vec3) {
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| {
            let side = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            (half * Vec3::new(side(0), side(1), side(2))).to_array()
        })
        .collect();
    let sides: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let indices: Vec<u32> = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    let d = device();
    let vertices = foreign::buffer(d, BufferUsages::VERTEX, cast_slice(&corners));
    let indices = foreign::buffer(d, BufferUsages::INDEX, cast_slice(&indices));
    let mesh = CasterMesh {
        label: "box",
        vertices: &vertices,
        layout: VertexLayout::PACKED,
        indices: Some(Indices {
            buffer: &indices,
            format: IndexFormat::Uint32,
        }),
        range: 0..36,
        base_vertex: 0,
        bounds: Aabb {
            min: -half,
            max: half,
        },
    };
    let mesh = set.add_mesh(&mesh).expect("valid");
    let place = Affine3A::from_translation(center);
    set.add_caster(mesh, place).expect("valid");
}

/// Returns the masks of a light's techniques over the floor. The box is a caster, and so is the
/// floor if `has_floor`.
fn masks(
    light: Light,
    center: Vec3,
    has_floor: bool,
    techniques: &[Arc<dyn ShadowTechnique>],
) -> Vec<Vec<f32>> {
    let program = ForwardProgram::floor(device(), SIZE);
    let mut set = program.set(SetBudget::default(), StillLayers::Auto);
    add_box(&mut set, center, HALF);
    if has_floor {
        add_box(&mut set, Vec3::NEG_Y * FLOOR_HALF.y, FLOOR_HALF);
    }
    let add = |technique: &Arc<dyn ShadowTechnique>| {
        set.add_light(ShadowedLight {
            light,
            technique: technique.clone(),
            priority: 1.0,
        })
        .expect("valid")
    };
    let ids: Vec<_> = techniques.iter().map(add).collect();
    let frame = SetFrame {
        camera: &camera(),
        geometry: None,
    };
    program.update(&mut set, &frame);
    assert_eq!(set.unserved_lights().count(), 0);
    let mut forward = Forward::default();
    ids.iter()
        .map(|&id| forward.mask(&program, &set, set.index_of(id).expect("is there")))
        .collect()
}

/// Returns the analytic mask at the points that the camera sees; `None` elsewhere, and within
/// `border` points of the shadow's edge.
fn expected(light: &Light, center: Vec3, border: i32) -> Vec<Option<f32>> {
    let clip_from_world = camera().space().clip_from_world();
    let hidden_at = |x: i32, y: i32| is_hidden(floor_point(x, y), center, light);
    let value = |x: i32, y: i32| {
        let clip = clip_from_world.project_point3(floor_point(x, y));
        let is_seen = clip.x.abs() < 1.0 && clip.y.abs() < 1.0 && clip.z < 1.0;
        let hidden = hidden_at(x, y);
        let mut around =
            (-border..=border).flat_map(|dy| (-border..=border).map(move |dx| (dx, dy)));
        let is_inner = around.all(|(dx, dy)| hidden_at(x + dx, y + dy) == hidden);
        (is_seen && is_inner).then_some(if hidden { 0.0 } else { 1.0 })
    };
    (0..SIZE.y as i32)
        .flat_map(|y| (0..SIZE.x as i32).map(move |x| value(x, y)))
        .collect()
}

/// Returns the number of points at which a mask isn't the analytic one, to within `tolerance`.
fn wrong_points(mask: &[f32], expected: &[Option<f32>], tolerance: f32) -> usize {
    let shadowed = expected.iter().filter(|&&v| v == Some(0.0)).count();
    assert!(shadowed > 20, "only {shadowed} points in shadow");
    let is_wrong = |(found, expected): (&f32, &Option<f32>)| {
        expected.is_some_and(|expected| (found - expected).abs() > tolerance)
    };
    mask.iter()
        .zip(expected)
        .filter(|&pair| is_wrong(pair))
        .count()
}

/// Returns suns and a lamp, each with the box whose shadow is in the middle of the floor.
fn lights() -> Vec<(Light, Vec3)> {
    let suns = [
        Vec3::new(0.3, -1.0, 0.2),
        Vec3::new(1.0, -0.4, -0.1),
        Vec3::new(-0.2, -0.5, -1.0),
    ];
    let mut lights: Vec<(Light, Vec3)> = suns
        .iter()
        .map(|&direction| {
            let sun = Light::Directional {
                direction: direction.normalize(),
                angular_diameter: 0.0,
            };
            (sun, direction * (HEIGHT / direction.y))
        })
        .collect();
    // The map ends at twice the distance of the box, above the floor.
    let lamp = Light::Spot {
        position: Vec3::Y * (HEIGHT + 1.5),
        direction: Vec3::NEG_Y,
        inner: 1.0,
        outer: 1.1,
        radius: 0.0,
    };
    lights.push((lamp, Vec3::Y * HEIGHT));
    lights
}

/// Returns a map for each layout that a light can have.
fn maps(light: &Light) -> Vec<ShadowMap> {
    let one = ShadowMap {
        size: 256,
        ..ShadowMap::default()
    };
    if light.position().is_some() {
        let cube = ShadowMap {
            layout: Layout::Cube,
            ..one
        };
        return vec![one, cube];
    }
    let cascades = |blend| ShadowMap {
        layout: Layout::Cascades(Cascades {
            count: 3,
            blend,
            ..Cascades::default()
        }),
        ..one
    };
    vec![one, cascades(0.0), cascades(4.0)]
}

#[test]
fn a_floor_that_casts_nothing_has_the_shadows_of_one_that_does() {
    for (light, center) in lights() {
        let mut techniques: Vec<Arc<dyn ShadowTechnique>> = Vec::new();
        for map in maps(&light) {
            techniques.push(Arc::new(Hard {}.on(map)));
            techniques.push(Arc::new(Pcf { radius: 1 }.on(map)));
        }
        let expected = expected(&light, center, 2);
        for has_floor in [false, true] {
            let masks = masks(light, center, has_floor, &techniques);
            for (i, mask) in masks.iter().enumerate() {
                let wrong = wrong_points(mask, &expected, 0.0);
                assert_eq!(wrong, 0, "technique {i} under {light:?}, {has_floor}");
            }
        }
        // Negative control: the shadow is beyond the map's far plane.
        let lit = ShadowMap {
            beyond_far: BeyondFar::Lit,
            ..maps(&light)[0]
        };
        let lit: [Arc<dyn ShadowTechnique>; 1] = [Arc::new(Hard {}.on(lit))];
        let masks = masks(light, center, false, &lit);
        assert!(wrong_points(&masks[0], &expected, 0.0) > 20, "{light:?}");
    }
}

/// All techniques with maps. Their filters are wider, and some are bounds.
#[test]
fn all_map_techniques_shadow_a_floor_that_casts_nothing() {
    for (light, center) in lights() {
        let expected = expected(&light, center, 4);
        // Not on cubes: next to the light the box's near plane is so close that moments lose their
        // precision.
        let maps = maps(&light);
        for &map in maps.iter().filter(|map| map.layout != Layout::Cube) {
            let mut techniques: Vec<Arc<dyn ShadowTechnique>> = Vec::new();
            for entry in umbrage_techniques::all() {
                let preset = (entry.preset)();
                if preset.map().is_some() {
                    techniques.push(preset.with_map(map).technique());
                }
            }
            assert!(techniques.len() > 8);
            let masks = masks(light, center, false, &techniques);
            for (technique, mask) in techniques.iter().zip(&masks) {
                let wrong = wrong_points(mask, &expected, 0.05);
                let name = technique.name();
                assert_eq!(wrong, 0, "{name} with {}, {light:?}", map.label());
            }
        }
    }
}
